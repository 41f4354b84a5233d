//! Messages in a description: additions to a DBC, or complete definitions.

use super::Formula;
use crate::protection::{ChecksumTable, CounterTable, E2eTable, ProtectionTable};
use crate::signal_value::SignalValue;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// Who sends a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Sender {
    /// The described device.
    Device,
    /// The other side.
    Host,
}

/// When a message is sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SendKind {
    /// Periodically.
    #[default]
    Cyclic,
    /// When a signal differs from the value last sent.
    OnChange,
    /// When a signal changes to a value other than its start value: a button that is pressed, but not when it is released.
    OnEvent,
    /// Periodically, and also when a signal changes.
    CyclicAndOnChange,
}

/// Byte order of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ByteOrder {
    /// Least significant byte first (Intel, `@1` in a DBC).
    #[default]
    Little,
    /// Most significant byte first (Motorola, `@0` in a DBC).
    Big,
}

/// Messages in either form.
#[derive(Debug, JsonSchema)]
#[schemars(untagged)]
pub enum Messages {
    /// `[message.NAME]`: additions to a message of the DBC.
    Rules(BTreeMap<String, MessageRules>),
    /// `[[message]]`: complete definitions.
    Tables(Vec<MessageTable>),
}

impl Default for Messages {
    fn default() -> Self {
        Self::Rules(BTreeMap::new())
    }
}

impl Messages {
    /// The complete definitions, if it is these.
    pub fn tables(&self) -> Option<&[MessageTable]> {
        match self {
            Self::Rules(_) => None,
            Self::Tables(tables) => Some(tables),
        }
    }

    /// The keys that both forms have, by the name of the message.
    pub fn rules(&self) -> BTreeMap<String, MessageRules> {
        match self {
            Self::Rules(rules) => rules.clone(),
            Self::Tables(tables) => {
                tables.iter().map(|table| (table.name.clone(), table.rules())).collect()
            }
        }
    }
}

wire::either! { Messages, "a map",
    map(map) => Deserialize::deserialize(map).map(Messages::Rules),
    list(list) => Deserialize::deserialize(list).map(Messages::Tables),
}

/// Declares the two forms of a message, which have these keys in common.
macro_rules! messages {
    ($($(#[$about:meta])* $key:ident: $type:ty,)+) => {
        /// Additions to a message of a DBC.
        #[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct MessageRules {
            $($(#[$about])* pub $key: $type,)+
            /// A checksum among the signals.
            checksum: Option<ChecksumTable>,
        }

        /// Complete definition of a message, without a DBC.
        #[derive(Debug, Clone, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct MessageTable {
            /// Its name.
            pub name: String,
            /// Who sends it.
            pub sent_by: Sender,
            /// What it is.
            #[serde(default)]
            pub doc: String,
            /// Identifier on CAN.
            pub can_id: Option<u32>,
            /// Extended identifier (29 bits).
            pub extended: Option<bool>,
            /// CAN FD frame, up to 64 bytes, with the data phase at the faster bit rate.
            #[serde(default)]
            pub fd: bool,
            /// Start bytes of a packet on a serial line.
            pub start: Option<Vec<u8>>,
            /// Checksum at the end of a packet: `sum8`, `xor8` or a CRC of the catalogue, such as `crc16-modbus`. In a line of text
            /// its hexadecimal digits are at `{checksum}`. As a table: a checksum among the fields.
            pub checksum: Option<ChecksumKind>,
            /// What the checksum covers.
            pub checksum_over: Option<ChecksumOver>,
            /// The characters of a line of text between which the checksum covers it; by default all before the checksum.
            pub checksum_between: Option<[char; 2]>,
            /// Byte order of the checksum.
            pub checksum_order: Option<ByteOrder>,
            /// Line of text on a serial line, with `{Signal:.2}` in place of a number and `{checksum}` in place of its checksum.
            pub text: Option<String>,
            /// Fields, one after another.
            #[serde(default)]
            pub fields: Vec<FieldTable>,
            $($(#[$about])* pub $key: $type,)+
        }

        impl MessageTable {
            fn rules(&self) -> MessageRules {
                let checksum = match &self.checksum {
                    Some(ChecksumKind::Field(table)) => Some(table.clone()),
                    Some(ChecksumKind::Trailer(_)) | None => None,
                };
                MessageRules { checksum, $($key: self.$key.clone(),)+ }
            }
        }
    };
}

messages! {
    /// Period, s.
    period_s: Option<f64>,
    /// When it is sent: periodically, when its values change, or both.
    send: Option<SendKind>,
    /// Period of the repetitions after a change, s.
    fast_period_s: Option<f64>,
    /// Number of repetitions after a change.
    fast_times: Option<u32>,
    /// Minimum time between the preceding message and one that a change triggers, s.
    min_delay_s: Option<f64>,
    /// Sent in reply to this message.
    answers: Option<String>,
    /// Delay of the reply, s.
    delay_s: Option<f64>,
    /// Condition for a reply, evaluated when the message arrives.
    when: Option<Formula>,
    /// Number of messages in the reply. In its expressions, `part` counts them from 1.
    times: Option<Formula>,
    /// Time between the messages of a reply, s.
    every_s: Option<f64>,
    /// The reply to requests that are refused because another one is being answered.
    busy: Option<bool>,
    /// For a received message: what happens if it arrives while an earlier one is still being answered.
    while_answering: Option<WhileAnswering>,
    /// Maximum number of waiting requests. Default: 8.
    queue: Option<usize>,
    /// For a received message: values of its signals before the first message.
    #[serde(default)]
    initial: BTreeMap<String, SignalValue>,
    /// For a received message: after this time without one, s, its signals return to their initial values.
    timeout_s: Option<f64>,
    /// A counter that advances with each message.
    counter: Option<CounterTable>,
    /// Counter and checksum of an AUTOSAR E2E profile.
    e2e: Option<E2eTable>,
}

impl MessageRules {
    pub fn protection(&self) -> ProtectionTable {
        ProtectionTable {
            counter: self.counter.clone(),
            checksum: self.checksum.clone(),
            e2e: self.e2e.clone(),
        }
    }
}

impl MessageTable {
    /// The name of the checksum at its end.
    pub fn trailer(&self) -> Option<&str> {
        match &self.checksum {
            Some(ChecksumKind::Trailer(name)) => Some(name),
            Some(ChecksumKind::Field(_)) | None => None,
        }
    }
}

/// Name of a checksum at the end of a packet, or a table for a checksum among the fields.
#[derive(Debug, Clone, PartialEq, Eq, JsonSchema)]
#[schemars(untagged)]
pub enum ChecksumKind {
    /// Its name.
    Trailer(String),
    /// What it is.
    Field(ChecksumTable),
}

wire::either! { ChecksumKind, "the name of a checksum or a table with its `signal` and its `crc`",
    text(name) => Ok(ChecksumKind::Trailer(name.to_owned())),
    map(map) => ChecksumTable::deserialize(map).map(ChecksumKind::Field),
}

/// What happens to a request while another one is being answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WhileAnswering {
    /// It is refused, with the `busy` reply if there is one.
    Refuse,
    /// It waits until all earlier ones have been answered.
    Queue,
}

/// What a checksum covers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ChecksumOver {
    /// All bytes between the start bytes and the checksum.
    #[default]
    BehindStart,
    /// The start bytes too.
    All,
}

#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FieldTable {
    /// Name of the signal.
    pub name: String,
    /// Type of a field in a frame or packet; a line of text needs no types.
    #[serde(rename = "type")]
    pub kind: Option<FieldType>,
    /// Byte order.
    pub order: Option<ByteOrder>,
    /// Its value per count.
    pub scale: Option<f64>,
    /// Its value at count 0.
    pub offset: Option<f64>,
    /// Its unit.
    #[serde(default)]
    pub unit: String,
    /// Smallest value.
    pub minimum: Option<f64>,
    /// Largest value.
    pub maximum: Option<f64>,
    /// What it is.
    #[serde(default)]
    pub doc: String,
}

/// A number of whole bytes: unsigned, signed (two's complement) or floating-point (IEEE 754), with its bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FieldType {
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
