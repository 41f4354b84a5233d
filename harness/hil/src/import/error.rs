//! Errors of an import.

use bus_log::{Format, LogError};
use record::run_folder::RunFolderError;
use std::path::{Path, PathBuf};

#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum ImportError {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Log(#[from] LogError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Folder(#[from] RunFolderError),
    /// No step of the plan moves the base.
    #[error("failed to judge a CAN log by plan {plan}: none of its steps moves the base")]
    #[diagnostic(help(
        "a plan with `straight`, `turn` or `lap` is needed; `hil list plans` shows them"
    ))]
    NothingMoves { plan: String },
    #[error("the log has more than {most} frames, and an import keeps all of them in memory")]
    #[diagnostic(help(
        "import a part: `hil log convert` writes it as a candump log, one line a frame, which `split -l` divides"
    ))]
    TooLong { most: usize },
    #[error("which channel of the log is the line `{line}`?")]
    #[diagnostic(help("--channel {line}=CHANNEL states it, one of: {known}"))]
    NoLine {
        line: String,
        /// Channels of the log with the line's medium.
        known: String,
    },
    /// The log does not have the channel that the command line names.
    #[error("the log has no channel `{channel}`")]
    #[diagnostic(help("--channel takes one of: {known}"))]
    NoChannel { channel: String, known: String },
    #[error("there is no frame in the log")]
    #[diagnostic(help(
        "is it empty, or of another format? --from {} says which it is",
        Format::any_name()
    ))]
    NoFrames,
    /// What is wrong with this log.
    #[error("failed to import {}", log.display())]
    #[diagnostic(forward(source))]
    Of { log: PathBuf, source: Box<ImportError> },
    /// The log contains no frame of a base.
    #[error("failed to find a base in the log: no frame has an identifier of the K2A command set")]
    #[diagnostic(help(
        "--channel says which bus the base is on; its identifiers are in wire/dbc/k2a.dbc"
    ))]
    NoBase,
}

impl ImportError {
    /// Names the log, unless the error does so itself.
    pub fn of(self, log: &Path) -> Self {
        match self {
            Self::TooLong { .. }
            | Self::NoLine { .. }
            | Self::NoChannel { .. }
            | Self::NoFrames
            | Self::NoBase => Self::Of { log: log.to_owned(), source: Box::new(self) },
            Self::Log(_) | Self::Folder(_) | Self::NothingMoves { .. } | Self::Of { .. } => self,
        }
    }
}
