//! Objects and errors of a CANopen device.

use super::{Formula, SourceTable};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// An object of the EDS.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ObjectTable {
    /// Its value: an expression of parameters, states and objects that masters write.
    expression: Option<Formula>,
    /// `in.MACHINE = { STATE = ... }`: values in certain states of a state machine. In all others, `expression` applies.
    #[serde(rename = "in", default)]
    in_states: BTreeMap<String, BTreeMap<String, Formula>>,
    /// Its value per count. Default: 1.
    pub scale: Option<f64>,
    /// Its unit.
    #[serde(default)]
    pub unit: String,
}

impl ObjectTable {
    /// True if the file says its value, which masters then only read.
    pub fn is_computed(&self) -> bool {
        self.expression.is_some() || !self.in_states.is_empty()
    }

    pub fn source(&self) -> SourceTable {
        SourceTable {
            expression: self.expression.clone(),
            in_states: self.in_states.clone(),
            ..SourceTable::default()
        }
    }
}

/// An error that the device reports by an EMCY message.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EmergencyTable {
    /// The condition of the error. When it ends, the error has gone.
    pub when: Formula,
    /// The error code, 0x1000 to 0xFFFF.
    pub code: u16,
}
