//! Result of a trial.

use super::folder::Folder;
use crate::console::{Style, measurements_table};
use crate::made::Made;
use crate::outcome::{Measurement, Outcome, PropertySummary, Summary};
use std::fmt;
use std::path::Path;

/// Result of a trial. It prints as the table of `hil run`, with the failures and the path of the run folder.
#[derive(Debug)]
pub struct TrialRun {
    summary: Summary,
    made: Made,
    folder: Folder,
}

impl TrialRun {
    pub(super) fn new(summary: Summary, made: Made, folder: Folder) -> Self {
        let mut run = Self { summary, made, folder };
        if !run.passed() {
            run.folder.keep();
        }
        run
    }

    /// Whether every measurement is inside its band and no property broke. Marginal passes.
    pub fn passed(&self) -> bool {
        self.summary.outcome == Outcome::Passed
    }

    /// The contents of `summary.json`.
    pub const fn summary(&self) -> &Summary {
        &self.summary
    }

    /// The measurement of that name; `None` if the plan does not declare it.
    pub fn measurement(&self, name: &str) -> Option<&Measurement> {
        self.summary.measurements.iter().find(|one| one.name == name)
    }

    /// The value of that measurement, in its unit; `None` if it is not declared, or nothing was measured.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.measurement(name)?.value
    }

    /// The summary of the property of that name; `None` if the plan does not declare it.
    pub fn property(&self, name: &str) -> Option<&PropertySummary> {
        self.summary.properties.iter().find(|one| one.name == name)
    }

    /// Calibrations and models that the plan made, for [`load_after`](super::Trial::load_after).
    pub const fn made(&self) -> &Made {
        &self.made
    }

    /// The run folder. A temporary one is removed with this value if the run passed and its test does not fail.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }
}

impl fmt::Display for TrialRun {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let table = measurements_table(std::slice::from_ref(&self.summary), Style::PLAIN);
        let (seed, folder) = (self.summary.seed, self.folder.path().display());
        write!(f, "\n{table}seed {seed}, run folder {folder}")
    }
}
