//! A functional mock-up unit in a description.

use super::Formula;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// A functional mock-up unit (FMI 2.0 or 3.0, co-simulation) that is part of the device's physics.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FmuTable {
    /// The FMU, relative to this file.
    pub file: String,
    /// Communication step, s. Default: that of the FMU, or else the device's `step_s`.
    pub step_s: Option<f64>,
    /// Its parameters, by name: expressions of the device's parameters. Tunable ones follow them during a run.
    #[serde(default)]
    pub parameters: BTreeMap<String, Formula>,
    /// Its inputs, by name: expressions of received signals, parameters and states, held for a step.
    #[serde(default)]
    pub inputs: BTreeMap<String, Formula>,
    /// States of the device, each with the name of the FMU's output that it is.
    #[serde(default)]
    pub outputs: BTreeMap<String, String>,
}
