//! One measured value of a quantity: output of the engine, input of checks, reports and identification.

mod kept;

pub use kept::{Full, Observations, Observed};

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// One measured value, in the declared unit of the quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Observation {
    /// Name of the quantity, e.g. `lap.gyro_error`; see [`crate::quantities`].
    pub quantity: String,
    /// The value.
    pub value: f64,
    /// Its standard uncertainty, in the same unit.
    pub uncertainty: f64,
    /// Circumstances: `direction` (+1 ccw, -1 cw), `temperature`, `run`, ...
    pub tags: BTreeMap<String, f64>,
}

impl Observation {
    /// The value of a tag.
    pub fn tag(&self, name: &str) -> Option<f64> {
        self.tags.get(name).copied()
    }
}
