//! The content of a description file.

mod canopen;
mod fmu;
mod machine;
mod message;
mod uds;

pub(crate) use canopen::{EmergencyTable, ObjectTable};
pub(crate) use fmu::FmuTable;
pub(crate) use machine::{MachineTable, TransitionTable};
pub use message::FieldType;
pub(crate) use message::{
    ChecksumOver, FieldTable, MessageRules, MessageTable, Messages, WhileAnswering,
};
pub(crate) use uds::{
    AccessTable, DidTable, DtcTable, NumberTable, RoutineTable, SecurityTable, UdsTable,
};

use crate::error::Mistake;
use crate::lookup::Outside;
use crate::place::Place;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::{self, Deserializer, Visitor};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use toml::Spanned;
use wire::serial::{Parity, SerialSettings};

/// A description.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct File {
    /// Name of the device, and of this file. Its random numbers depend on the name.
    pub(crate) name: String,
    /// Title in one line.
    #[serde(default)]
    pub(crate) title: String,
    /// Source of the numbers in this file.
    #[serde(default)]
    pub(crate) source: String,
    /// DBC file with its messages and signals, relative to this file.
    pub(crate) dbc: Option<String>,
    /// Node of the DBC that the device is. It sends this node's messages and receives all others.
    pub(crate) node: Option<String>,
    /// EDS or DCF file of a CANopen device, relative to this file, instead of `dbc`.
    pub(crate) eds: Option<String>,
    /// Node identifier of the CANopen device, from 1 to 127.
    #[schemars(range(min = 1, max = 127))]
    pub(crate) node_id: Option<i64>,
    /// Step of the integration, s. Default: 0.01.
    pub(crate) step_s: Option<f64>,
    /// Settings of its serial line. Default: the device is on CAN.
    pub(crate) serial: Option<SerialTable>,
    /// Parameters. Plans can set them as `device.NAME`.
    #[serde(default)]
    pub(crate) parameter: BTreeMap<String, ParameterTable>,
    /// Internal states, which change over time.
    #[serde(default)]
    pub(crate) state: BTreeMap<String, StateTable>,
    /// Look-up tables. Expressions call them by name: `ocv(soc)`.
    #[serde(default)]
    pub(crate) table: BTreeMap<String, LookupTable>,
    /// State machines: modes and transitions.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, MachineTable>")]
    pub(crate) machine: BTreeMap<String, Spanned<MachineTable>>,
    /// Sources of the signals that it sends.
    #[serde(default)]
    pub(crate) signal: BTreeMap<String, SourceTable>,
    /// Diagnostics: a UDS server.
    pub(crate) uds: Option<UdsTable>,
    /// Physics in a functional mock-up unit.
    pub(crate) fmu: Option<FmuTable>,
    /// Objects of the EDS, by their ParameterName in lower case with `_`: values and units.
    #[serde(default)]
    pub(crate) object: BTreeMap<String, ObjectTable>,
    /// Errors of a CANopen device.
    #[serde(default)]
    pub(crate) emergency: BTreeMap<String, EmergencyTable>,
    /// Messages: additions to those of the DBC, or complete definitions.
    #[serde(default)]
    pub(crate) message: Messages,
}

#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SerialTable {
    /// Baud rate.
    #[schemars(range(min = 1))]
    baud: u32,
    /// Data bits. Default: 8.
    #[schemars(range(min = 5, max = 8))]
    data_bits: Option<u8>,
    /// Parity. Default: none.
    #[serde(default)]
    #[schemars(schema_with = "parity_schema")]
    parity: Option<Parity>,
    /// Stop bits. Default: 1.
    #[schemars(range(min = 1, max = 2))]
    stop_bits: Option<u8>,
}

impl File {
    /// The section that has a variable of this name.
    pub(crate) fn section_of(&self, name: &str) -> Option<&'static str> {
        let sections = [
            ("state", self.state.contains_key(name)),
            ("parameter", self.parameter.contains_key(name)),
            ("machine", self.machine.contains_key(name)),
            ("table", self.table.contains_key(name)),
        ];
        sections.into_iter().find(|(_, has)| *has).map(|(section, _)| section)
    }
}

impl SerialTable {
    /// Eight data bits, no parity and one stop bit, unless it says otherwise.
    pub(crate) fn settings(self) -> Result<SerialSettings, Mistake> {
        let plain = SerialSettings::new_8n1(self.baud);
        let place = Place::file().key("serial");
        if self.baud == 0 {
            return Err(Mistake::new(place.key("baud"), "baud = 0, expected bits per second"));
        }
        let bits = |name, set: Option<u8>, usual, (least, most)| match set.unwrap_or(usual) {
            bits if (least..=most).contains(&bits) => Ok(bits),
            bits => {
                let text = format!("{name} = {bits}, expected {least} to {most}");
                Err(Mistake::new(place.key(name), text))
            }
        };
        Ok(SerialSettings {
            data_bits: bits("data_bits", self.data_bits, plain.data_bits, (5, 8))?,
            parity: self.parity.unwrap_or(plain.parity),
            stop_bits: bits("stop_bits", self.stop_bits, plain.stop_bits, (1, 2))?,
            ..plain
        })
    }
}

#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ParameterTable {
    /// Value until a plan sets another.
    pub(crate) value: f64,
    /// Unit.
    #[serde(default)]
    pub(crate) unit: String,
    /// Smallest value that a plan may set.
    pub(crate) minimum: Option<f64>,
    /// Largest value that a plan may set.
    pub(crate) maximum: Option<f64>,
    /// What it is.
    #[serde(default)]
    pub(crate) doc: String,
}

#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StateTable {
    /// Value at power-on; the expression can use parameters only. Default: 0.
    pub(crate) start: Option<Formula>,
    /// Rate of change, per second.
    pub(crate) rate: Option<Formula>,
    /// Value at every moment, instead of `rate`. Without either, the state stays until a state machine sets it.
    pub(crate) value: Option<Formula>,
    /// Its unit.
    #[serde(default)]
    pub(crate) unit: String,
    /// What it is.
    #[serde(default)]
    pub(crate) doc: String,
}

/// A look-up table, linear between its points.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LookupTable {
    /// Points along the first axis, increasing.
    pub(crate) x: Option<Vec<f64>>,
    /// Values at these points; with `z`, the points along the second axis.
    pub(crate) y: Option<Vec<f64>>,
    /// Values of a table with two axes: one row for each `x`, with one value for each `y`.
    pub(crate) z: Option<Vec<Vec<f64>>>,
    /// CSV file instead, relative to this file: a column of points and a column of values. If its first line also holds
    /// numbers, it is a table with two axes.
    pub(crate) csv: Option<String>,
    /// Values outside the points.
    #[serde(default)]
    pub(crate) outside: Outside,
}

#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SourceTable {
    /// Expression of parameters, states and received signals.
    pub(crate) expression: Option<Formula>,
    /// `in.MACHINE = { STATE = ... }`: values in certain states of a state machine. In all others, `expression` applies.
    #[serde(rename = "in", default)]
    pub(crate) in_states: BTreeMap<String, BTreeMap<String, Formula>>,
    /// `[[t, value], ...]`: this value from t seconds on.
    pub(crate) steps: Option<Vec<(f64, f64)>>,
    /// CSV file with a column of times and a column of values, relative to this file.
    pub(crate) csv: Option<String>,
    /// Name of the column of times, s.
    pub(crate) time: Option<String>,
    /// Name of the column of values.
    pub(crate) value: Option<String>,
    /// Interpolate linearly between points; otherwise the value steps at each point.
    pub(crate) interpolate: Option<bool>,
    /// Start again at the end.
    pub(crate) repeat: Option<bool>,
    /// File with the identified model of a sensor, relative to this file. The source then gives the true value, and the
    /// model the sensor's error.
    pub(crate) model: Option<String>,
    /// Temperature for the model, degC.
    pub(crate) temperature: Option<Formula>,
    /// Heading for the model, deg.
    pub(crate) heading: Option<Formula>,
    /// White noise that is added, rms, in the unit of the signal.
    pub(crate) noise: Option<f64>,
}

fn parity_schema(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "enum": ["none", "even", "odd"], "default": "none" })
}

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
