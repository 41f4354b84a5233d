//! Results that plans make for later ones.

use crate::Plan;
use crate::calibrations;
use crate::models;
use controller::calibration::Calibration;
use identification::finding::Finding;
use identification::model::Model;
use std::collections::BTreeMap;

/// The result of one identification.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// For reports.
    pub finding: Finding,
    /// For controllers and emulators.
    pub model: Model,
}

/// Results of plans, by name.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Made {
    /// Calibrations.
    pub calibrations: BTreeMap<String, Calibration>,
    /// Identified models.
    pub models: BTreeMap<String, Model>,
    /// The findings of these models.
    pub findings: BTreeMap<String, Finding>,
}

impl Made {
    /// Adds placeholders for the results of `plan`: checks of later plans only need their names.
    pub fn promise(&mut self, plan: &Plan) {
        let calibrations = calibrations::made_by(plan).into_iter();
        self.calibrations.extend(calibrations.map(|name| (name, Calibration::default())));
        self.models.extend(models::made_by(plan).into_iter().map(|name| (name, models::empty())));
    }

    /// Adds the results of a later plan, which replace those with the same name.
    pub fn extend(&mut self, later: Self) {
        self.calibrations.extend(later.calibrations);
        self.models.extend(later.models);
        self.findings.extend(later.findings);
    }

    /// Whether there are no results.
    pub fn is_empty(&self) -> bool {
        self.calibrations.is_empty() && self.models.is_empty()
    }
}
