//! Why a command cannot do its work, and the exit status of each cause.

use crate::import::ImportError;
use crate::replay::ReplayError;
use bus_log::LogError;
use campaign::{AccountError, JournalError, RegressionError, RepetitionError};
use dataset::DatasetError;
use dataset::export::ExportError;
use exchange::mcap::McapExportError;
use exchange::mf4::Mf4ExportError;
use exchange::tables::TablesError;
use harness::operator::AnswersError;
use harness::run::{PrepareError, RerunError};
use harness::run_live::LiveRunError;
use identification::identify::IdentifyError;
use live::crossing::KernelError;
use live::emulation::EmulationError;
use live::world::{LiveError, PlacementError, Unfit};
use miette::Diagnostic;
use plan::library::LibraryError;
use ports::PortError;
use record::outcome::{EXIT_BAD_INPUT, Outcome};
use record::run_folder::RunFolderError;
use rig::bench::DevicesError;
use std::io;
use std::path::{Path, PathBuf};

#[derive(Debug, thiserror::Error, Diagnostic)]
pub(super) enum Cause {
    /// A plan, or a file that it names, cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Prepare(#[from] PrepareError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Folder(#[from] RunFolderError),
    /// The arguments do not fit together, or do not fit the plans.
    #[error("{message}")]
    Arguments {
        message: String,
        #[help]
        help: String,
    },
    /// The standard output cannot be written.
    #[error("failed to write to the standard output")]
    Output(#[source] io::Error),
    /// A file beside the run folders cannot be written.
    #[error("failed to write {}", path.display())]
    File { path: PathBuf, source: io::Error },
    /// A data package cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Data(#[from] DatasetError),
    /// A run cannot be converted to a data set.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Export(ExportError),
    /// A run cannot be written as tables.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Tables(TablesError),
    /// A run cannot be written as an MCAP file.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Mcap(McapExportError),
    /// A bus log cannot be read or written.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Log(#[from] LogError),
    /// A bus log cannot be imported as a run.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Import(ImportError),
    /// The journal of a campaign cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Journal(#[from] JournalError),
    /// The account of a campaign cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Account(#[from] AccountError),
    /// A campaign cannot use its server, or the connection was lost.
    #[error(transparent)]
    #[diagnostic(transparent)]
    #[cfg(feature = "nats")]
    Nats(#[from] campaign_nats::NatsError),
    /// A case cannot be saved as a plan.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Regression(#[from] RegressionError),
    /// A model file cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Model(LibraryError),
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
    /// Answers to the operator's questions cannot be used, or are missing.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Answers(#[from] AnswersError),
    /// The bench file cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Bench(#[from] LibraryError),
    /// The bench does not come up.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Live(#[from] LiveError),
    /// The bench does not fit the plan.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Placement(#[from] PlacementError),
    /// What a plan asks for cannot be done on the bench.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Unfit(#[from] Unfit),
    /// The requested repetitions can show nothing.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Repetition(#[from] RepetitionError),
    /// The kernel lacks the buses that the lines are to cross.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Kernel(#[from] KernelError),
    /// Devices cannot be emulated, or the emulation broke off.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Emulation(#[from] EmulationError),
    /// A log cannot be played to a port, or the replay broke off.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Replay(#[from] ReplayError),
    /// A run cannot be repeated from its record.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Rerun(#[from] RerunError),
    /// A device file cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Devices(#[from] DevicesError),
    /// The handler of Ctrl-C cannot be installed; without it no run could be stopped in order.
    #[error("failed to take over Ctrl-C")]
    Signals(#[source] ctrlc::Error),
}

fn by(model: Option<&Path>) -> String {
    model.map_or_else(String::new, |model| format!(" by {}", model.display()))
}

impl Cause {
    /// Bad input is what the caller can fix by calling differently: a folder that is not ours or holds no run, but not
    /// a full disk.
    pub(super) const fn exit_status(&self) -> u8 {
        match self {
            Self::Log(error) if !error.is_bad_input() => Outcome::Error.exit_status(),
            Self::Tables(error) if error.is_bad_input() => EXIT_BAD_INPUT,
            Self::Prepare(_)
            | Self::Arguments { .. }
            | Self::Data(_)
            | Self::Log(_)
            | Self::Export(_)
            | Self::Import(_)
            | Self::Model(_)
            | Self::Rerun(_)
            | Self::Answers(_)
            | Self::Bench(_)
            | Self::Account(AccountError::Foreign { .. } | AccountError::Version { .. })
            | Self::Journal(JournalError::Other { .. } | JournalError::Broken { .. })
            | Self::Identify { .. } => EXIT_BAD_INPUT,
            #[cfg(feature = "nats")]
            Self::Nats(error) if error.is_bad_input() => EXIT_BAD_INPUT,
            Self::Devices(_) | Self::Placement(_) | Self::Unfit(_) | Self::Repetition(_) => {
                EXIT_BAD_INPUT
            }
            // Frames on a serial port, or bytes on a CAN port: nothing is broken.
            Self::Live(LiveError::Stopped) => Outcome::Aborted.exit_status(),
            Self::Live(LiveError::Port(PortError::WrongKind { .. })) => EXIT_BAD_INPUT,
            Self::Replay(ReplayError::Port(PortError::WrongKind { .. })) => EXIT_BAD_INPUT,
            Self::Kernel(KernelError::NoFrames { .. }) => EXIT_BAD_INPUT,
            Self::Live(_) | Self::Kernel(_) | Self::Emulation(_) | Self::Replay(_) => {
                Outcome::Error.exit_status()
            }
            Self::Folder(
                RunFolderError::Foreign { .. }
                | RunFolderError::Busy { .. }
                | RunFolderError::NoRun { .. }
                | RunFolderError::Read { .. }
                | RunFolderError::Summary { .. }
                | RunFolderError::Record { .. },
            ) => EXIT_BAD_INPUT,
            Self::Folder(
                RunFolderError::Write { .. }
                | RunFolderError::Remove { .. }
                | RunFolderError::ArtifactName { .. },
            )
            | Self::Account(AccountError::Io { .. })
            | Self::Journal(JournalError::Io { .. })
            | Self::Tables(_)
            | Self::Mcap(_)
            | Self::Regression(_)
            | Self::Output(_)
            | Self::File { .. }
            | Self::Findings(_)
            | Self::Signals(_) => Outcome::Error.exit_status(),
            #[cfg(feature = "nats")]
            Self::Nats(_) => Outcome::Error.exit_status(),
        }
    }
}

impl From<ImportError> for Cause {
    fn from(error: ImportError) -> Self {
        match error {
            ImportError::Log(error) => error.into(),
            ImportError::Folder(error) => error.into(),
            error => Self::Import(error),
        }
    }
}

impl From<ExportError> for Cause {
    fn from(error: ExportError) -> Self {
        match error {
            ExportError::Folder(error) => error.into(),
            ExportError::Data(error) => error.into(),
            error => Self::Export(error),
        }
    }
}

impl From<TablesError> for Cause {
    fn from(error: TablesError) -> Self {
        match error {
            TablesError::Folder(error) => error.into(),
            error => Self::Tables(error),
        }
    }
}

impl From<Mf4ExportError> for Cause {
    fn from(error: Mf4ExportError) -> Self {
        match error {
            Mf4ExportError::Folder(error) => error.into(),
            Mf4ExportError::Write(error) => error.into(),
        }
    }
}

impl From<McapExportError> for Cause {
    fn from(error: McapExportError) -> Self {
        match error {
            McapExportError::Folder(error) => error.into(),
            error => Self::Mcap(error),
        }
    }
}

impl From<LiveRunError> for Cause {
    fn from(error: LiveRunError) -> Self {
        match error {
            LiveRunError::Folder(error) => error.into(),
            LiveRunError::Live { source, .. } => (*source).into(),
            LiveRunError::Placement(error) => error.into(),
            LiveRunError::Unfit(error) => error.into(),
        }
    }
}
