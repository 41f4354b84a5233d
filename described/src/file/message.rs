//! Messages in a description: additions to a DBC, or complete definitions.

use super::Formula;
use crate::layout::{ByteOrder, SendKind, Sender};
use crate::protection::{ChecksumTable, CounterTable, E2eTable, ProtectionTable};
use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{self, Deserializer, MapAccess, Visitor};
use std::collections::BTreeMap;
use std::fmt;

/// Messages in either form, for editors; to read one of them the form is known before.
#[derive(JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "it is only described")]
pub(crate) enum Messages {
    /// `[message.NAME]`: what a DBC does not say.
    Rules(BTreeMap<String, MessageRules>),
    /// `[[message]]`: all of each.
    Tables(Vec<MessageTable>),
}

impl Default for Messages {
    fn default() -> Self {
        Self::Tables(Vec::new())
    }
}

/// What a DBC does not say of a message.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct MessageRules {
    /// How often it is sent, s.
    pub(crate) period_s: Option<f64>,
    /// What makes it be sent: its period, changes of its values, or both.
    pub(crate) send: Option<SendKind>,
    /// After a change it is sent again this long after one another, s.
    pub(crate) fast_period_s: Option<f64>,
    /// So often.
    pub(crate) fast_times: Option<u32>,
    /// A change has it sent so long after the one before at the earliest, s.
    pub(crate) min_delay_s: Option<f64>,
    /// It is sent when this message has been heard.
    pub(crate) answers: Option<String>,
    /// How long after that, s.
    pub(crate) delay_s: Option<f64>,
    /// It answers only where this holds when the message is heard.
    pub(crate) when: Option<Formula>,
    /// It is an answer of so many messages; `part` in its expressions counts them from 1.
    pub(crate) times: Option<Formula>,
    /// So long after one another, s.
    pub(crate) every_s: Option<f64>,
    /// It answers what is refused because something else is being answered.
    pub(crate) busy: Option<bool>,
    /// What becomes of such a message, where it is heard, as long as one of its kind is being answered.
    pub(crate) while_answering: Option<WhileAnswering>,
    /// How many wait at the most; 8 where it is absent.
    pub(crate) queue: Option<usize>,
    /// Signals of a message that is heard: their values until the first one has come.
    #[serde(default)]
    pub(crate) initial: BTreeMap<String, f64>,
    /// Without it for so long, s, its signals are the initial ones again.
    pub(crate) timeout_s: Option<f64>,
    /// A counter that goes on with each message.
    counter: Option<CounterTable>,
    /// A checksum among the signals.
    checksum: Option<ChecksumTable>,
    /// Counter and checksum of a profile of AUTOSAR.
    e2e: Option<E2eTable>,
}

impl MessageRules {
    /// Its counter and checksum.
    pub(crate) fn protection(&self) -> ProtectionTable {
        ProtectionTable {
            counter: self.counter.clone(),
            checksum: self.checksum.clone(),
            e2e: self.e2e.clone(),
        }
    }
}

/// All of a message, where there is no DBC.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct MessageTable {
    /// Its name.
    pub(crate) name: String,
    /// Who sends it.
    pub(crate) sent_by: Sender,
    /// What it is.
    #[serde(default)]
    pub(crate) doc: String,
    /// Identifier on CAN.
    pub(crate) can_id: Option<u32>,
    /// The identifier has 29 bits.
    pub(crate) extended: Option<bool>,
    /// It is a CAN FD frame, of up to 64 bytes, whose data goes at the faster rate.
    #[serde(default)]
    pub(crate) fd: bool,
    /// Bytes that a packet on a serial line begins with.
    pub(crate) start: Option<Vec<u8>>,
    /// At the end of a packet `sum8`, `xor8` or a CRC of the catalogue, such as `crc16-modbus`; or a table of a
    /// checksum among the fields.
    pub(crate) checksum: Option<ChecksumKind>,
    /// A counter that goes on with each message.
    counter: Option<CounterTable>,
    /// Counter and checksum of a profile of AUTOSAR.
    e2e: Option<E2eTable>,
    /// What the checksum covers.
    pub(crate) checksum_over: Option<ChecksumOver>,
    /// Which byte of the checksum comes first.
    pub(crate) checksum_order: Option<ByteOrder>,
    /// A line of text on a serial line, with `{Signal:.2}` where a number stands.
    pub(crate) text: Option<String>,
    /// Numbers, one behind the other.
    #[serde(default)]
    pub(crate) fields: Vec<FieldTable>,
    /// How often it is sent, s.
    period_s: Option<f64>,
    /// What makes it be sent: its period, changes of its values, or both.
    send: Option<SendKind>,
    /// After a change it is sent again this long after one another, s.
    fast_period_s: Option<f64>,
    /// So often.
    fast_times: Option<u32>,
    /// A change has it sent so long after the one before at the earliest, s.
    min_delay_s: Option<f64>,
    /// It is sent when this message has been heard.
    answers: Option<String>,
    /// How long after that, s.
    delay_s: Option<f64>,
    /// It answers only where this holds when the message is heard.
    when: Option<Formula>,
    /// It is an answer of so many messages; `part` in its expressions counts them from 1.
    times: Option<Formula>,
    /// So long after one another, s.
    every_s: Option<f64>,
    /// It answers what is refused because something else is being answered.
    busy: Option<bool>,
    /// What becomes of such a message, where it is heard, as long as one of its kind is being answered.
    while_answering: Option<WhileAnswering>,
    /// How many wait at the most; 8 where it is absent.
    queue: Option<usize>,
    /// Values of its signals until the first one has come, where it is heard.
    #[serde(default)]
    initial: BTreeMap<String, f64>,
    /// Without it for so long, s, its signals are the initial ones again.
    timeout_s: Option<f64>,
}

impl MessageTable {
    pub(crate) fn rules(&self) -> MessageRules {
        MessageRules {
            period_s: self.period_s,
            send: self.send,
            fast_period_s: self.fast_period_s,
            fast_times: self.fast_times,
            min_delay_s: self.min_delay_s,
            answers: self.answers.clone(),
            delay_s: self.delay_s,
            when: self.when.clone(),
            times: self.times.clone(),
            every_s: self.every_s,
            busy: self.busy,
            while_answering: self.while_answering,
            queue: self.queue,
            initial: self.initial.clone(),
            timeout_s: self.timeout_s,
            counter: self.counter.clone(),
            checksum: match &self.checksum {
                Some(ChecksumKind::Field(table)) => Some(table.clone()),
                Some(ChecksumKind::Trailer(_)) | None => None,
            },
            e2e: self.e2e.clone(),
        }
    }

    /// The name of the checksum at its end.
    pub(crate) fn trailer(&self) -> Option<&str> {
        match &self.checksum {
            Some(ChecksumKind::Trailer(name)) => Some(name),
            Some(ChecksumKind::Field(_)) | None => None,
        }
    }
}

/// A checksum at the end of a packet, by its name, or one among the fields.
#[derive(Debug, Clone, PartialEq, Eq, JsonSchema)]
#[schemars(untagged)]
pub(crate) enum ChecksumKind {
    /// Its name.
    Trailer(String),
    /// What it is.
    Field(ChecksumTable),
}

impl<'de> Deserialize<'de> for ChecksumKind {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = ChecksumKind;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the name of a checksum or a table with its `signal` and its `crc`")
            }
            fn visit_str<E: de::Error>(self, name: &str) -> Result<ChecksumKind, E> {
                Ok(ChecksumKind::Trailer(name.to_owned()))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<ChecksumKind, A::Error> {
                ChecksumTable::deserialize(MapAccessDeserializer::new(map)).map(ChecksumKind::Field)
            }
        }
        deserializer.deserialize_any(Either)
    }
}

/// What becomes of a message as long as another is being answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum WhileAnswering {
    /// It is not used, and gets the `busy` answer where there is one.
    Refuse,
    /// It waits until all before it have been answered.
    Queue,
}

/// What a checksum covers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum ChecksumOver {
    /// All between the start bytes and the checksum.
    #[default]
    BehindStart,
    /// The start bytes too.
    All,
}

#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct FieldTable {
    /// Name of the signal.
    pub(crate) name: String,
    /// How it lies in the bytes; of a line of text it is absent.
    #[serde(rename = "type")]
    pub(crate) kind: Option<FieldType>,
    /// Which byte comes first.
    pub(crate) order: Option<ByteOrder>,
    /// Its value per count.
    pub(crate) scale: Option<f64>,
    /// Its value at count 0.
    pub(crate) offset: Option<f64>,
    /// Its unit.
    #[serde(default)]
    pub(crate) unit: String,
    /// Least value.
    pub(crate) minimum: Option<f64>,
    /// Greatest value.
    pub(crate) maximum: Option<f64>,
    /// What it is.
    #[serde(default)]
    pub(crate) doc: String,
}

/// Whole bytes that are a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum FieldType {
    U8,
    U16,
    U24,
    U32,
    U64,
    I8,
    I16,
    I24,
    I32,
    I64,
    F32,
    F64,
}
