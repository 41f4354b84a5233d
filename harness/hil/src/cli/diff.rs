//! `hil diff`: compares two runs.

use super::determinism::difference;
use super::failure::Failure;
use super::say;
use clap::Args;
use record::outcome::Outcome;
use record::run_folder::RunFolder;
use std::path::PathBuf;
use views::console::{Style, comparison};

/// Compares two runs: verdicts and figures side by side, and the first event that differs.
///
/// Fails if a verdict differs or exists in only one of them.
#[derive(Debug, Args)]
pub(super) struct DiffArguments {
    /// A run folder.
    #[arg(value_name = "RUN")]
    one: PathBuf,
    /// Another.
    #[arg(value_name = "OTHER")]
    other: PathBuf,
}

impl DiffArguments {
    pub(super) fn execute(&self) -> Result<Outcome, Failure> {
        let (one, other) = (RunFolder::open(&self.one)?, RunFolder::open(&self.other)?);
        let (table, differing) = comparison(&one.summary()?, &other.summary()?, Style::of_stdout());
        let records = match difference(&one, &other)? {
            Some(what) => format!("first difference: {what}"),
            None => "the records are the same".to_owned(),
        };
        let verdicts = match differing {
            0 => "no verdict differs".to_owned(),
            1 => "1 verdict differs".to_owned(),
            several => format!("{several} verdicts differ"),
        };
        say(&format!("{table}\n{records}\n{verdicts}\n"))?;
        Ok(if differing == 0 { Outcome::Passed } else { Outcome::Failed })
    }
}
