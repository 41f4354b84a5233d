//! Why a command cannot do its work, and the exit status of each cause.

use crate::import::ImportError;
use crate::replay::ReplayError;
use bus_log::LogError;
use campaign::{AccountError, JournalError, RegressionError, RepetitionError};
use dataset::DatasetError;
use harness::operator::AnswersError;
use harness::run::{PrepareError, RerunError};
use identification::identify::IdentifyError;
use live::crossing::KernelError;
use live::emulation::EmulationError;
use live::world::{LiveError, PlacementError, Unfit};
use miette::Diagnostic;
use plan::device_files::DevicesError;
use plan::library::LibraryError;
use ports::PortError;
use record::outcome::{EXIT_BAD_INPUT, Outcome};
use record::run_folder::RunFolderError;
use std::io;
use std::path::{Path, PathBuf};

/// An error that ends a command.
pub(in crate::cli) trait Cause: Diagnostic + Send + Sync + 'static {
    /// Bad input is what the caller can fix by calling differently: a folder that is not ours or holds no run, but not
    /// a full disk.
    fn exit_status(&self) -> u8;
}

/// What goes wrong in the command itself.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub(super) enum OwnCause {
    /// The arguments do not fit together, or do not fit the plans.
    #[error("{message}")]
    Arguments {
        message: String,
        #[help]
        help: String,
    },
    #[error("failed to write to the standard output")]
    Output(#[source] io::Error),
    /// A file beside the run folders.
    #[error("failed to write {}", path.display())]
    File { path: PathBuf, source: io::Error },
    /// The data and the model are valid, but do not fit each other.
    #[error("failed to identify {dataset}{}", by(model.as_deref()))]
    Identify {
        dataset: String,
        /// The file of the model, if given.
        model: Option<PathBuf>,
        source: IdentifyError,
    },
    #[error("failed to write down what was found")]
    Findings(#[source] Box<dyn std::error::Error + Send + Sync>),
    /// Without the handler of Ctrl-C no run could be stopped in order.
    #[error("failed to take over Ctrl-C")]
    Signals(#[source] ctrlc::Error),
}

fn by(model: Option<&Path>) -> String {
    model.map_or_else(String::new, |model| format!(" by {}", model.display()))
}

const BAD: u8 = EXIT_BAD_INPUT;
const ERROR: u8 = Outcome::Error.exit_status();

macro_rules! exit_statuses {
    ($($error:ty { $($arms:tt)* })*) => {
        $(impl Cause for $error {
            fn exit_status(&self) -> u8 {
                match self { $($arms)* }
            }
        })*
    };
}

exit_statuses! {
    OwnCause { Self::Arguments { .. } | Self::Identify { .. } => BAD, _ => ERROR }
    PrepareError { _ => BAD }
    RerunError { _ => BAD }
    AnswersError { _ => BAD }
    LibraryError { _ => BAD }
    DevicesError { _ => BAD }
    PlacementError { _ => BAD }
    Unfit { _ => BAD }
    RepetitionError { _ => BAD }
    DatasetError { _ => BAD }
    RegressionError { _ => ERROR }
    EmulationError { _ => ERROR }
    LogError { error => if error.is_bad_input() { BAD } else { ERROR } }
    AccountError { Self::Foreign { .. } | Self::Version { .. } => BAD, Self::Io { .. } => ERROR }
    JournalError { Self::Other { .. } | Self::Broken { .. } => BAD, Self::Io { .. } => ERROR }
    KernelError { Self::NoFrames { .. } | Self::NoFd { .. } => BAD, _ => ERROR }
    // Frames on a serial port, or bytes on a CAN port: nothing is broken.
    ReplayError { Self::Port(PortError::WrongKind { .. }) => BAD, _ => ERROR }
    // As in the summary of the run, which is in its folder by then.
    LiveError { Self::Stopped => Outcome::Aborted.exit_status(), _ => ERROR }
    RunFolderError {
        Self::Foreign { .. } | Self::NoFolder { .. } | Self::Busy { .. } => BAD,
        Self::NoRun { .. } | Self::NoSummary { .. } => BAD,
        Self::Read { .. } | Self::Summary { .. } | Self::Record { .. } => BAD,
        Self::Write { .. } | Self::Remove { .. } | Self::ArtifactName { .. } => ERROR,
    }
    ImportError {
        Self::Log(error) => error.exit_status(),
        Self::Folder(error) => error.exit_status(),
        _ => BAD,
    }
    dataset::export::ExportError {
        Self::Folder(error) => error.exit_status(),
        _ => BAD,
    }
    exchange::ExportError {
        Self::Folder(error) => error.exit_status(),
        Self::Log(error) => error.exit_status(),
        Self::Foreign { .. } => BAD,
        Self::Write { .. } => ERROR,
    }
}

#[cfg(feature = "nats")]
exit_statuses! {
    campaign_nats::NatsError { error => if error.is_bad_input() { BAD } else { ERROR } }
}
