//! What plans make for later ones.

use crate::Plan;
use crate::calibrations;
use crate::models;
use controller::calibration::Calibration;
use identification::finding::Finding;
use identification::model::Model;
use std::collections::BTreeMap;

/// What was found by one identification.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// What to read.
    pub finding: Finding,
    /// What to use.
    pub model: Model,
}

/// What plans make, by name.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Made {
    /// Calibrations.
    pub calibrations: BTreeMap<String, Calibration>,
    /// Identified models.
    pub models: BTreeMap<String, Model>,
    /// What was found, of each of those models.
    pub findings: BTreeMap<String, Finding>,
}

impl Made {
    /// Takes for granted what `plan` will make: all that counts is that it has a name.
    pub fn promise(&mut self, plan: &Plan) {
        let calibrations = calibrations::made_by(plan).into_iter();
        self.calibrations.extend(calibrations.map(|name| (name, Calibration::default())));
        self.models.extend(models::made_by(plan).into_iter().map(|name| (name, models::empty())));
    }

    /// Adds what a later plan made; of two with one name the later one stays.
    pub fn extend(&mut self, later: Self) {
        self.calibrations.extend(later.calibrations);
        self.models.extend(later.models);
        self.findings.extend(later.findings);
    }

    /// Nothing was made.
    pub fn is_empty(&self) -> bool {
        self.calibrations.is_empty() && self.models.is_empty()
    }
}
