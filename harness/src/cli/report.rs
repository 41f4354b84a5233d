//! `hil report`: draws recorded runs again.

use super::failure::Failure;
use super::say;
use crate::outcome::Outcome;
use crate::report::render;
use crate::run_folder::{REPORT, RunFolder};
use clap::Args;
use std::path::{Path, PathBuf};

/// Draws report.html of recorded runs again, from summary and record.
///
/// The verdicts are those of the summary; `hil check` makes new ones.
#[derive(Debug, Args)]
pub(super) struct ReportArguments {
    /// Run folders.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
}

impl ReportArguments {
    pub(super) fn execute(&self) -> Result<Outcome, Failure> {
        for run in &self.runs {
            let report = draw(run)?;
            say(&format!("{}\n", report.display()))?;
        }
        Ok(Outcome::Passed)
    }
}

fn draw(run: &Path) -> Result<PathBuf, Failure> {
    let folder = RunFolder::open(run)?;
    let summary = folder.summary()?;
    let records = folder.records()?;
    let header = records.header().clone();
    folder.write_report(&render(&summary, &header, records))?;
    Ok(folder.file(REPORT))
}
