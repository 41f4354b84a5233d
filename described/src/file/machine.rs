//! State machines in a description.

use super::Formula;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// A state machine.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct MachineTable {
    /// Names of the states. In expressions, the machine has the index of its state, from 0; `mode == "Closed"` works too.
    pub(crate) states: Vec<String>,
    /// State at power-on.
    pub(crate) start: String,
    /// Transitions. The first one whose conditions hold is taken.
    pub(crate) transitions: Vec<TransitionTable>,
    /// `STATE = { state = value }`: values that are set when the machine enters a state.
    #[serde(default)]
    pub(crate) enter: BTreeMap<String, BTreeMap<String, Formula>>,
    /// What it is.
    #[serde(default)]
    pub(crate) doc: String,
}

/// A transition. All of `when`, `on` and `after_s` that are given must hold.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct TransitionTable {
    /// State from which it leads, or several. Default: any other state.
    pub(crate) from: Option<OneOrSeveral>,
    /// State to which it leads.
    pub(crate) to: String,
    /// Condition.
    pub(crate) when: Option<Formula>,
    /// Message that triggers it.
    pub(crate) on: Option<String>,
    /// Time in the state, s: the transition happens then, or, with a condition or a message, not before.
    pub(crate) after_s: Option<f64>,
    /// `state = value`: values that the transition sets.
    #[serde(default)]
    pub(crate) set: BTreeMap<String, Formula>,
}

/// A name, or an array of several.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected the name of a state or an array of several")]
#[schemars(inline)]
pub(crate) enum OneOrSeveral {
    One(String),
    Several(Vec<String>),
}

impl OneOrSeveral {
    pub(crate) fn as_slice(&self) -> &[String] {
        match self {
            Self::One(one) => std::slice::from_ref(one),
            Self::Several(several) => several,
        }
    }
}
