//! The content of a description file.

mod machine;
mod message;

pub(crate) use machine::{MachineTable, TransitionTable};
pub(crate) use message::{
    ChecksumOver, FieldTable, FieldType, MessageRules, MessageTable, Messages, WhileAnswering,
};

use crate::lookup::Outside;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::{self, Deserializer, Visitor};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use toml::Spanned;
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
    /// Look-up tables, called by their names: `ocv(soc)`.
    #[serde(default)]
    pub(crate) table: BTreeMap<String, LookupTable>,
    /// Machines of states: modes, and what leads from one to another.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, MachineTable>")]
    pub(crate) machine: BTreeMap<String, Spanned<MachineTable>>,
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
    /// What it is, at every moment; instead of `rate`. Without either it stays until a machine sets it.
    pub(crate) value: Option<Formula>,
    /// Its unit.
    #[serde(default)]
    pub(crate) unit: String,
    /// What it is.
    #[serde(default)]
    pub(crate) doc: String,
}

/// Points, and values between them.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LookupTable {
    /// Where the points are, increasing.
    pub(crate) x: Option<Vec<f64>>,
    /// The values there; with `z` where the points are along the second axis.
    pub(crate) y: Option<Vec<f64>>,
    /// In two dimensions a row of values for each `x`, one for each `y`.
    pub(crate) z: Option<Vec<Vec<f64>>>,
    /// File beside this one instead: a column of points and one of values, or, with numbers in its first line too, both
    /// axes and what is between them.
    pub(crate) csv: Option<String>,
    /// Beside the points: the value at the end, or on along the last two.
    #[serde(default)]
    pub(crate) outside: Outside,
}

#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SourceTable {
    /// Of parameters, states and signals that are heard.
    pub(crate) expression: Option<Formula>,
    /// `in.MACHINE = { STATE = ... }`: what it is in states of a machine; in the others it is the `expression`.
    #[serde(rename = "in", default)]
    pub(crate) in_states: BTreeMap<String, BTreeMap<String, Formula>>,
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
    /// File with a model that was identified, beside this one: how a sensor errs. The source is what is
    /// true then.
    pub(crate) model: Option<String>,
    /// The temperature that the model sees, degC.
    pub(crate) temperature: Option<Formula>,
    /// The heading that the model sees, deg.
    pub(crate) heading: Option<Formula>,
    /// White noise on top, rms, in the unit of the signal.
    pub(crate) noise: Option<f64>,
}

/// [`Parity`] in its serialised form.
fn parity_schema(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "enum": ["none", "even", "odd"], "default": "none" })
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
