//! What stands in a description, as it is written.

use crate::layout::{ByteOrder, Sender};
use crate::protection::{ChecksumTable, CounterTable, E2eTable, ProtectionTable};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{self, Deserializer, MapAccess, Visitor};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use wire::serial::{Parity, SerialSettings};

/// A description. `M` is the form in which it speaks of messages: tables that say all of one
/// ([`MessageTable`]), or rules for those of a DBC ([`MessageRules`]).
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, bound(deserialize = "M: Deserialize<'de> + Default"))]
#[schemars(bound = "M: JsonSchema + Default")]
pub(crate) struct File<M> {
    /// The name that its random numbers belong to; the file's too.
    pub(crate) name: String,
    /// What it is, in a line.
    #[serde(default)]
    pub(crate) title: String,
    /// Where its numbers are from.
    #[serde(default)]
    pub(crate) source: String,
    /// File with its messages and their signals, beside this one.
    pub(crate) dbc: Option<String>,
    /// Which node of the DBC the device is: it sends that node's messages and hears the others.
    pub(crate) node: Option<String>,
    /// Step of the integration, s; 0.01 where it is absent.
    pub(crate) step_s: Option<f64>,
    /// The serial line that it is on; on CAN where it is absent.
    pub(crate) serial: Option<SerialTable>,
    /// Numbers that plans can set as `device.NAME`.
    #[serde(default)]
    pub(crate) parameter: BTreeMap<String, ParameterTable>,
    /// What goes on within.
    #[serde(default)]
    pub(crate) state: BTreeMap<String, StateTable>,
    /// What it says: a source of each signal that it sends.
    #[serde(default)]
    pub(crate) signal: BTreeMap<String, SourceTable>,
    /// What the DBC does not say of its messages, or all of each.
    #[serde(default)]
    pub(crate) message: M,
}

#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SerialTable {
    /// Symbols per second.
    baud: u32,
    /// Bits of a byte; 8 where it is absent.
    data_bits: Option<u8>,
    /// Parity bit; none where it is absent.
    #[serde(default)]
    #[schemars(schema_with = "parity_schema")]
    parity: Option<Parity>,
    /// Stop bits; 1 where it is absent.
    stop_bits: Option<u8>,
}

impl SerialTable {
    /// Eight data bits, no parity and one stop bit, unless it says otherwise.
    pub(crate) fn settings(self) -> SerialSettings {
        let plain = SerialSettings::new_8n1(self.baud);
        SerialSettings {
            data_bits: self.data_bits.unwrap_or(plain.data_bits),
            parity: self.parity.unwrap_or(plain.parity),
            stop_bits: self.stop_bits.unwrap_or(plain.stop_bits),
            ..plain
        }
    }
}

#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ParameterTable {
    /// Its value, until a plan sets it.
    pub(crate) value: f64,
    /// Unit of its values.
    #[serde(default)]
    pub(crate) unit: String,
    /// The least that a plan may set.
    pub(crate) minimum: Option<f64>,
    /// The greatest that a plan may set.
    pub(crate) maximum: Option<f64>,
    /// What it is.
    #[serde(default)]
    pub(crate) doc: String,
}

#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StateTable {
    /// Its value at power-on, of parameters alone; 0 where it is absent.
    pub(crate) start: Option<Formula>,
    /// Its change per second.
    pub(crate) rate: Option<Formula>,
    /// What it is, at every moment; instead of `rate`.
    pub(crate) value: Option<Formula>,
    /// Its unit.
    #[serde(default)]
    pub(crate) unit: String,
    /// What it is.
    #[serde(default)]
    pub(crate) doc: String,
}

#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SourceTable {
    /// Of parameters, states and signals that are heard.
    pub(crate) expression: Option<Formula>,
    /// `[[t, value], ...]`: from t seconds on that value.
    pub(crate) steps: Option<Vec<(f64, f64)>>,
    /// File with a column of times and one of values, beside this one.
    pub(crate) csv: Option<String>,
    /// Name of the column of times, s.
    pub(crate) time: Option<String>,
    /// Name of the column of values.
    pub(crate) value: Option<String>,
    /// Linear between two points; else a step at each.
    pub(crate) interpolate: Option<bool>,
    /// From the beginning again once it has ended.
    pub(crate) repeat: Option<bool>,
    /// File with a model that was identified, beside this one: how a sensor of a rate errs. The source is the
    /// true rate then.
    pub(crate) model: Option<String>,
    /// The temperature that the model sees, degC.
    pub(crate) temperature: Option<Formula>,
    /// The heading that the model sees, deg.
    pub(crate) heading: Option<Formula>,
    /// White noise on top, rms, in the unit of the signal.
    pub(crate) noise: Option<f64>,
}

/// [`Parity`], as it is written.
fn parity_schema(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "enum": ["none", "even", "odd"], "default": "none" })
}

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
    /// It is sent when this message has been heard.
    pub(crate) answers: Option<String>,
    /// How long after that, s.
    pub(crate) delay_s: Option<f64>,
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
    /// What protects it.
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
    /// It is sent when this message has been heard.
    answers: Option<String>,
    /// How long after that, s.
    delay_s: Option<f64>,
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
            answers: self.answers.clone(),
            delay_s: self.delay_s,
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

/// A number, or an expression.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Formula {
    Number(f64),
    Expression(String),
}

impl JsonSchema for Formula {
    fn schema_name() -> Cow<'static, str> {
        "Formula".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "description": "A number, or an expression in quotes.", "type": ["number", "string"] })
    }
}

impl<'de> Deserialize<'de> for Formula {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl Visitor<'_> for Either {
            type Value = Formula;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number or an expression in quotes")
            }
            fn visit_f64<E: de::Error>(self, value: f64) -> Result<Formula, E> {
                Ok(Formula::Number(value))
            }
            fn visit_i64<E: de::Error>(self, value: i64) -> Result<Formula, E> {
                Ok(Formula::Number(value as f64))
            }
            fn visit_str<E: de::Error>(self, value: &str) -> Result<Formula, E> {
                Ok(Formula::Expression(value.to_owned()))
            }
        }
        deserializer.deserialize_any(Either)
    }
}
