//! State machines in a description.

use super::Formula;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// States of which it is in one, and what leads from one to another.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct MachineTable {
    /// Their names. In expressions it is the place of its state among them, from 0, or `mode == "Closed"`.
    pub(crate) states: Vec<String>,
    /// The one at power-on.
    pub(crate) start: String,
    /// What leads from one to another: the first one that may.
    pub(crate) transitions: Vec<TransitionTable>,
    /// `STATE = { state = value }`: what is set when it comes to a state.
    #[serde(default)]
    pub(crate) enter: BTreeMap<String, BTreeMap<String, Formula>>,
    /// What it is.
    #[serde(default)]
    pub(crate) doc: String,
}

/// What leads to a state: all that is said of `when`, `on` and `after_s` has to be.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct TransitionTable {
    /// The state that it leads from, or several; from any other one where it is absent.
    pub(crate) from: Option<OneOrSeveral>,
    /// The state that it leads to.
    pub(crate) to: String,
    /// A condition.
    pub(crate) when: Option<Formula>,
    /// This message is heard.
    pub(crate) on: Option<String>,
    /// So long in the state, s: at that moment, and at the earliest then where there is a condition or a message too.
    pub(crate) after_s: Option<f64>,
    /// `state = value`: what is set on the way.
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
