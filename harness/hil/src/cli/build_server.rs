//! Output for a build server beside the standard output: a summary in Markdown.
//!
//! GitHub names a file for summaries in `GITHUB_STEP_SUMMARY`; every step appends to it.

use super::failure::Failure;
use clap::Args;
use std::env;
use std::fs::OpenOptions;
use std::io::Write as _;
use std::path::PathBuf;

/// Names the file of GitHub's summaries.
const STEP_SUMMARY: &str = "GITHUB_STEP_SUMMARY";

/// Where the summary goes.
#[derive(Debug, Clone, Default, Args)]
pub(super) struct SummaryArguments {
    /// Append a summary in Markdown to this file. [default: the file that GITHUB_STEP_SUMMARY names]
    #[arg(long, value_name = "FILE")]
    summary: Option<PathBuf>,
}

impl SummaryArguments {
    pub(super) fn append(&self, markdown: &str) -> Result<(), Failure> {
        let named = || env::var_os(STEP_SUMMARY).filter(|name| !name.is_empty()).map(PathBuf::from);
        let Some(path) = self.summary.clone().or_else(named) else { return Ok(()) };
        let mut file = OpenOptions::new()
            .create(true)
            .append(true)
            .open(&path)
            .map_err(|source| Failure::file(&path, source))?;
        file.write_all(markdown.as_bytes()).map_err(|source| Failure::file(&path, source))
    }
}

#[cfg(test)]
mod tests {
    use super::SummaryArguments;

    #[test]
    fn a_summary_is_appended() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("summary.md");
        let arguments = SummaryArguments { summary: Some(path.clone()) };
        arguments.append("one\n").unwrap();
        arguments.append("two\n").unwrap();
        assert_eq!(std::fs::read_to_string(path).unwrap(), "one\ntwo\n");
    }
}
