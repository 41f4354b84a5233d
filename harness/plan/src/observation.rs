//! One measured value of a quantity: what the engine emits and what checks, reports and identification read.

mod kept;

pub use kept::{Full, Observations, Observed};

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// One measured value of a quantity, in the unit that the quantity is declared in.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Observation {
    /// Name of the quantity, e.g. `lap.gyro_error`; see [`crate::quantities`].
    pub quantity: String,
    /// Its value.
    pub value: f64,
    /// Its standard uncertainty, in the same unit.
    pub uncertainty: f64,
    /// What else was so: `direction` (+1 ccw, -1 cw), `temperature`, `run`, ...
    pub tags: BTreeMap<String, f64>,
}

impl Observation {
    /// What else was so.
    pub fn tag(&self, name: &str) -> Option<f64> {
        self.tags.get(name).copied()
    }
}
