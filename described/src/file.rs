//! What stands in a description, as it is written.

use crate::layout::{ByteOrder, Sender};
use serde::Deserialize;
use serde::de::{self, Deserializer, Visitor};
use std::collections::BTreeMap;
use std::fmt;
use wire::serial::{Parity, SerialSettings};

/// A description. `M` is the form in which it speaks of messages: tables that say all of one
/// ([`MessageTable`]), or rules for those of a DBC ([`MessageRules`]).
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, bound(deserialize = "M: Deserialize<'de> + Default"))]
pub(crate) struct File<M> {
    pub(crate) name: String,
    #[serde(default)]
    pub(crate) title: String,
    #[serde(default)]
    pub(crate) source: String,
    pub(crate) dbc: Option<String>,
    pub(crate) node: Option<String>,
    pub(crate) step_s: Option<f64>,
    pub(crate) serial: Option<SerialTable>,
    #[serde(default)]
    pub(crate) parameter: BTreeMap<String, ParameterTable>,
    #[serde(default)]
    pub(crate) state: BTreeMap<String, StateTable>,
    #[serde(default)]
    pub(crate) signal: BTreeMap<String, SourceTable>,
    #[serde(default)]
    pub(crate) message: M,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SerialTable {
    baud: u32,
    data_bits: Option<u8>,
    parity: Option<Parity>,
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

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ParameterTable {
    pub(crate) value: f64,
    #[serde(default)]
    pub(crate) unit: String,
    pub(crate) minimum: Option<f64>,
    pub(crate) maximum: Option<f64>,
    #[serde(default)]
    pub(crate) doc: String,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct StateTable {
    pub(crate) start: Option<Formula>,
    pub(crate) rate: Option<Formula>,
    pub(crate) value: Option<Formula>,
    #[serde(default)]
    pub(crate) unit: String,
    #[serde(default)]
    pub(crate) doc: String,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SourceTable {
    pub(crate) expression: Option<Formula>,
    pub(crate) steps: Option<Vec<(f64, f64)>>,
    pub(crate) csv: Option<String>,
    pub(crate) time: Option<String>,
    pub(crate) value: Option<String>,
    pub(crate) interpolate: Option<bool>,
    pub(crate) repeat: Option<bool>,
    pub(crate) noise: Option<f64>,
}

/// What a DBC does not say of a message.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MessageRules {
    pub(crate) period_s: Option<f64>,
    pub(crate) answers: Option<String>,
    pub(crate) delay_s: Option<f64>,
    #[serde(default)]
    pub(crate) initial: BTreeMap<String, f64>,
    pub(crate) timeout_s: Option<f64>,
}

/// All of a message, where there is no DBC.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MessageTable {
    pub(crate) name: String,
    pub(crate) sent_by: Sender,
    #[serde(default)]
    pub(crate) doc: String,
    pub(crate) can_id: Option<u32>,
    pub(crate) extended: Option<bool>,
    pub(crate) start: Option<Vec<u8>>,
    pub(crate) checksum: Option<String>,
    pub(crate) checksum_over: Option<ChecksumOver>,
    pub(crate) checksum_order: Option<ByteOrder>,
    pub(crate) text: Option<String>,
    #[serde(default)]
    pub(crate) fields: Vec<FieldTable>,
    period_s: Option<f64>,
    answers: Option<String>,
    delay_s: Option<f64>,
    #[serde(default)]
    initial: BTreeMap<String, f64>,
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
        }
    }
}

/// What a checksum covers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum ChecksumOver {
    /// All between the start bytes and the checksum.
    #[default]
    BehindStart,
    /// The start bytes too.
    All,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FieldTable {
    pub(crate) name: String,
    #[serde(rename = "type")]
    pub(crate) kind: Option<FieldType>,
    pub(crate) order: Option<ByteOrder>,
    pub(crate) scale: Option<f64>,
    pub(crate) offset: Option<f64>,
    #[serde(default)]
    pub(crate) unit: String,
    pub(crate) minimum: Option<f64>,
    pub(crate) maximum: Option<f64>,
    #[serde(default)]
    pub(crate) doc: String,
}

/// Whole bytes that are a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
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
