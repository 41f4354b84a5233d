//! What a build server is told beside the standard output: a summary in Markdown, and the places of mistakes.
//!
//! GitHub names a file for summaries in `GITHUB_STEP_SUMMARY`; every step appends to it. Lines that begin with `::error` are
//! shown at the file that they name; they are written where GitHub runs, and nowhere else.

use super::failure::Failure;
use super::progress::Screen;
use clap::Args;
use std::env;
use std::fs::OpenOptions;
use std::io::Write as _;
use std::path::PathBuf;

/// Names the file of GitHub's summaries.
const STEP_SUMMARY: &str = "GITHUB_STEP_SUMMARY";
/// Is `true` where GitHub runs.
const ACTIONS: &str = "GITHUB_ACTIONS";

/// Where the summary goes.
#[derive(Debug, Clone, Default, Args)]
pub(super) struct SummaryArguments {
    /// Append a summary in Markdown to this file. [default: what GITHUB_STEP_SUMMARY names]
    #[arg(long, value_name = "FILE")]
    summary: Option<PathBuf>,
}

impl SummaryArguments {
    /// Appends it, where somebody wants it.
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

/// A mistake, shown at its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Annotation {
    /// File and line, counted from 1, where it is of a file.
    pub(super) place: Option<(String, usize)>,
    /// What it is about.
    pub(super) title: String,
    /// What is wrong.
    pub(super) message: String,
}

impl Annotation {
    /// Shows it on GitHub; elsewhere nothing is written.
    pub(super) fn show(&self, screen: &Screen) {
        if env::var_os(ACTIONS).is_some_and(|value| value == "true") {
            screen.note(&self.line());
        }
    }

    fn line(&self) -> String {
        let place = self.place.as_ref().map_or_else(String::new, |(file, line)| {
            format!("file={},line={line},", property(file))
        });
        format!("::error {place}title={}::{}", property(&self.title), data(&self.message))
    }
}

/// As GitHub's toolkit escapes the text of a command.
fn data(text: &str) -> String {
    text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
}

/// As it escapes a property of one.
fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}

#[cfg(test)]
mod tests {
    use super::{Annotation, SummaryArguments};

    #[test]
    fn a_summary_is_appended() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("summary.md");
        let arguments = SummaryArguments { summary: Some(path.clone()) };
        arguments.append("one\n").unwrap();
        arguments.append("two\n").unwrap();
        assert_eq!(std::fs::read_to_string(path).unwrap(), "one\ntwo\n");
    }

    #[test]
    fn no_text_breaks_out_of_its_line() {
        let annotation = Annotation {
            place: Some(("a,b:c.toml".to_owned(), 3)),
            title: "x, y".to_owned(),
            message: "100 %\n::error::no".to_owned(),
        };
        assert_eq!(
            annotation.line(),
            "::error file=a%2Cb%3Ac.toml,line=3,title=x%2C y::100 %25%0A::error::no"
        );
    }
}
