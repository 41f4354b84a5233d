//! Why a log makes no run.

use exchange::bus_log::LogError;
use record::run_folder::RunFolderError;

/// Why a log makes no run.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum ImportError {
    /// The log cannot be read.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Log(#[from] LogError),
    /// The run folder cannot be written.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Folder(#[from] RunFolderError),
    /// No step of the plan is one of the base.
    #[error("failed to judge a CAN log by plan {plan}: none of its steps moves the base")]
    #[diagnostic(help(
        "a plan with `straight`, `turn` or `lap` is needed; `hil list plans` shows them"
    ))]
    NothingMoves {
        /// The plan.
        plan: String,
    },
    /// No frame of a base.
    #[error("failed to find a base in the log: no frame has an identifier of the K2A command set")]
    #[diagnostic(help(
        "--channel says which bus the base is on; its identifiers are in wire/dbc/k2a.dbc"
    ))]
    NoBase,
}
