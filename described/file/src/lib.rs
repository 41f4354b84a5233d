//! The content of a description file: its tables, as `described` reads them, and their JSON schema.
//!
//! What is generated to read them runs once a file and is half of all that a device needs. Apart, it is built without
//! optimisation, and the device with.

#![expect(
    missing_docs,
    reason = "what is documented here stands in the schema, where the name of a table says what it is"
)]

mod canopen;
mod fmu;
mod isotp;
mod machine;
mod message;
mod one_or_several;
mod protection;
mod signal_value;
mod uds;

pub use canopen::{EmergencyTable, ObjectTable};
pub use fmu::FmuTable;
pub use isotp::{IsoTpTable, NormalFixed};
pub use machine::{MachineTable, TransitionTable};
pub use message::{
    ByteOrder, ChecksumOver, FieldTable, FieldType, MessageRules, MessageTable, Messages, SendKind,
    Sender, WhileAnswering,
};
pub use one_or_several::OneOrSeveral;
pub use protection::{ChecksumTable, CounterTable, E2eTable, Profile, ProtectionTable};
pub use signal_value::SignalValue;
pub use uds::{
    AccessTable, DidTable, DtcTable, NumberTable, RoutineTable, SecurityTable, UdsTable,
};

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::str::FromStr;
use toml::Spanned;
use wire::serial::Parity;

/// A description.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct File {
    /// Name of the device, and of this file. Its random numbers depend on the name.
    pub name: String,
    /// Title in one line.
    #[serde(default)]
    pub title: String,
    /// Source of the numbers in this file.
    #[serde(default)]
    pub source: String,
    /// DBC file with its messages and signals, relative to this file.
    pub dbc: Option<String>,
    /// Node of the DBC that the device is. It sends this node's messages and receives all others.
    pub node: Option<String>,
    /// EDS or DCF file of a CANopen device, relative to this file, instead of `dbc`.
    pub eds: Option<String>,
    /// Node identifier of the CANopen device, from 1 to 127.
    #[schemars(range(min = 1, max = 127))]
    pub node_id: Option<i64>,
    /// Step of the integration, s. Default: 0.01.
    pub step_s: Option<f64>,
    /// Settings of its serial line. Default: the device is on CAN.
    pub serial: Option<SerialTable>,
    /// Parameters. Plans can set them as `device.NAME`.
    #[serde(default)]
    pub parameter: BTreeMap<String, ParameterTable>,
    /// Internal states, which change over time.
    #[serde(default)]
    pub state: BTreeMap<String, StateTable>,
    /// Look-up tables. Expressions call them by name: `ocv(soc)`.
    #[serde(default)]
    pub table: BTreeMap<String, LookupTable>,
    /// State machines: modes and transitions.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, MachineTable>")]
    pub machine: BTreeMap<String, Spanned<MachineTable>>,
    /// Sources of the signals that it sends.
    #[serde(default)]
    pub signal: BTreeMap<String, SourceTable>,
    /// Diagnostics: a UDS server.
    pub uds: Option<UdsTable>,
    /// Physics in a functional mock-up unit.
    pub fmu: Option<FmuTable>,
    /// Objects of the EDS, by their ParameterName in lower case with `_`: values and units.
    #[serde(default)]
    pub object: BTreeMap<String, ObjectTable>,
    /// Errors of a CANopen device.
    #[serde(default)]
    pub emergency: BTreeMap<String, EmergencyTable>,
    /// Messages: additions to those of the DBC, or complete definitions.
    #[serde(default)]
    pub message: Messages,
}

#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SerialTable {
    /// Baud rate.
    #[schemars(range(min = 1))]
    pub baud: u32,
    /// Data bits. Default: 8.
    #[schemars(range(min = 5, max = 8))]
    pub data_bits: Option<u8>,
    /// Parity. Default: none.
    #[serde(default)]
    #[schemars(schema_with = "parity_schema")]
    pub parity: Option<Parity>,
    /// Stop bits. Default: 1.
    #[schemars(range(min = 1, max = 2))]
    pub stop_bits: Option<u8>,
}

/// Reads the file in whichever of its two forms it has.
impl FromStr for File {
    type Err = toml::de::Error;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        toml::from_str(text)
    }
}

impl File {
    /// The section that has a variable of this name.
    pub fn section_of(&self, name: &str) -> Option<&'static str> {
        let sections = [
            ("state", self.state.contains_key(name)),
            ("parameter", self.parameter.contains_key(name)),
            ("machine", self.machine.contains_key(name)),
            ("table", self.table.contains_key(name)),
        ];
        sections.into_iter().find(|(_, has)| *has).map(|(section, _)| section)
    }
}

#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParameterTable {
    /// Value until a plan sets another.
    pub value: f64,
    /// Unit.
    #[serde(default)]
    pub unit: String,
    /// Smallest value that a plan may set.
    pub minimum: Option<f64>,
    /// Largest value that a plan may set.
    pub maximum: Option<f64>,
    /// What it is.
    #[serde(default)]
    pub doc: String,
}

#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StateTable {
    /// Value at power-on; the expression can use parameters only. Default: 0.
    pub start: Option<Formula>,
    /// Rate of change, per second.
    pub rate: Option<Formula>,
    /// Value at every moment, instead of `rate`. Without either, the state stays until a state machine sets it.
    pub value: Option<Formula>,
    /// Its unit.
    #[serde(default)]
    pub unit: String,
    /// What it is.
    #[serde(default)]
    pub doc: String,
}

/// Values of a table outside its points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Outside {
    /// The last value.
    #[default]
    Clamp,
    /// Linear extrapolation of the last two points.
    Extrapolate,
}

/// A look-up table, linear between its points.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LookupTable {
    /// Points along the first axis, increasing.
    pub x: Option<Vec<f64>>,
    /// Values at these points; with `z`, the points along the second axis.
    pub y: Option<Vec<f64>>,
    /// Values of a table with two axes: one row for each `x`, with one value for each `y`.
    pub z: Option<Vec<Vec<f64>>>,
    /// CSV file instead, relative to this file: a column of points and a column of values. If its first line also holds
    /// numbers, it is a table with two axes.
    pub csv: Option<String>,
    /// Values outside the points.
    #[serde(default)]
    pub outside: Outside,
}

#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SourceTable {
    /// Expression of parameters, states and received signals.
    pub expression: Option<Formula>,
    /// `in.MACHINE = { STATE = ... }`: values in certain states of a state machine. In all others, `expression` applies.
    #[serde(rename = "in", default)]
    pub in_states: BTreeMap<String, BTreeMap<String, Formula>>,
    /// `[[t, value], ...]`: this value from t seconds on.
    pub steps: Option<Vec<(f64, f64)>>,
    /// CSV file with a column of times and a column of values, relative to this file.
    pub csv: Option<String>,
    /// Name of the column of times, s.
    pub time: Option<String>,
    /// Name of the column of values.
    pub value: Option<String>,
    /// Interpolate linearly between points; otherwise the value steps at each point.
    pub interpolate: Option<bool>,
    /// Start again at the time of the last point, whose value is sent only as the end of an interpolation.
    pub repeat: Option<bool>,
    /// File with the identified model of a sensor, relative to this file. The source then gives the true value, and the
    /// model the sensor's error.
    pub model: Option<String>,
    /// Temperature for the model, degC.
    pub temperature: Option<Formula>,
    /// Heading for the model, deg.
    pub heading: Option<Formula>,
    /// White noise that is added, rms, in the unit of the signal.
    pub noise: Option<f64>,
}

fn parity_schema(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "enum": ["none", "even", "odd"], "default": "none" })
}

#[derive(Debug, Clone, PartialEq)]
pub enum Formula {
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

wire::either! { Formula, "a number or an expression in quotes",
    number(value) => Ok(Formula::Number(value)),
    text(text) => Ok(Formula::Expression(text.to_owned())),
}
