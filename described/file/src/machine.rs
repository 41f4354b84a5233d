//! State machines in a description.

use super::{Formula, OneOrSeveral};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// A state machine.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MachineTable {
    /// Names of the states. In expressions, the machine has the index of its state, from 0; `mode == "Closed"` works too.
    pub states: Vec<String>,
    /// State at power-on.
    pub start: String,
    /// Transitions. The first one whose conditions hold is taken.
    pub transitions: Vec<TransitionTable>,
    /// `STATE = { state = value }`: values that are set when the machine enters a state.
    #[serde(default)]
    pub enter: BTreeMap<String, BTreeMap<String, Formula>>,
    /// What it is.
    #[serde(default)]
    pub doc: String,
}

/// A transition. All of `when`, `on` and `after_s` that are given must hold.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TransitionTable {
    /// State from which it leads, or several. Default: any other state.
    pub from: Option<OneOrSeveral<String>>,
    /// State to which it leads.
    pub to: String,
    /// Condition.
    pub when: Option<Formula>,
    /// Message that triggers it.
    pub on: Option<String>,
    /// Time in the state, s: the transition happens then, or, with a condition or a message, not before.
    pub after_s: Option<f64>,
    /// `state = value`: values that the transition sets.
    #[serde(default)]
    pub set: BTreeMap<String, Formula>,
}
