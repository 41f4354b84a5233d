//! Errors of an import.

use bus_log::LogError;
use record::run_folder::RunFolderError;

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
    #[error("failed to find a frame in the log")]
    NoFrames,
    /// The log contains no frame of a base.
    #[error("failed to find a base in the log: no frame has an identifier of the K2A command set")]
    #[diagnostic(help(
        "--channel says which bus the base is on; its identifiers are in wire/dbc/k2a.dbc"
    ))]
    NoBase,
}
