//! `hil report`: draws recorded runs and campaigns again.

use super::campaign::account::{self, is_campaign};
use super::envelopes;
use super::failure::Failure;
use super::progress::Screen;
use super::say;
use clap::Args;
use harness::run::unfinished;
use record::outcome::{Outcome, Summary};
use record::run_folder::{REPORT, RunFolder};
use std::path::{Path, PathBuf};
use views::report::render;
use wire::time::Timestamp;

/// Draws report.html again: of recorded runs from summary and record, of campaigns from campaign.json and the journal,
/// of envelopes from envelopes.json.
///
/// A truncated run is drawn as far as its record goes. The verdicts are those of the summary; `hil
/// check` makes new ones.
#[derive(Debug, Args)]
pub(super) struct ReportArguments {
    /// Run folders, and folders of campaigns and of envelopes.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
}

impl ReportArguments {
    pub(super) fn execute(&self, screen: &Screen) -> Result<Outcome, Failure> {
        for run in &self.runs {
            let report = if is_campaign(run) {
                account::draw(run)?
            } else if envelopes::are_in(run) {
                envelopes::draw(run)?
            } else {
                draw(run, screen)?
            };
            say(&format!("{}\n", report.display()))?;
        }
        Ok(Outcome::Passed)
    }
}

fn draw(run: &Path, screen: &Screen) -> Result<PathBuf, Failure> {
    let (_, folder) = screen.opened(run)?;
    let summary = match folder.summary_if_any()? {
        Some(summary) => summary,
        None => killed(&folder)?,
    };
    let records = folder.records()?;
    let header = records.header().clone();
    folder.write_report(&render(&summary, &header, records))?;
    Ok(folder.file(REPORT))
}

/// Summary of a run that was killed or is still running, from its record. `hil check` judges it.
fn killed(folder: &RunFolder) -> Result<Summary, Failure> {
    let mut records = folder.records()?;
    let header = records.header().clone();
    let last =
        records.by_ref().map_while(Result::ok).last().map_or(Timestamp::ZERO, |record| record.at);
    Ok(unfinished(&header, &header.plan, last))
}
