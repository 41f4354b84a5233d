//! What keeps a command from doing its work, and the exit status of each.

use super::annotation::Annotation;
use crate::import::ImportError;
use campaign::{AccountError, JournalError, RegressionError};
use dataset::DatasetError;
use dataset::export::ExportError;
use exchange::bus_log::LogError;
use exchange::mcap::McapExportError;
use exchange::tables::TablesError;
use harness::operator::AnswersError;
use harness::run::PrepareError;
use identification::identify::IdentifyError;
use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme};
use plan::library::LibraryError;
use record::outcome::{EXIT_BAD_INPUT, Outcome};
use record::run_folder::RunFolderError;
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};
use std::{fmt, io};

/// Columns of a message; sentences in wider lines are hard to read.
const WIDTH: usize = 100;

/// Why a command did not do its work. A run that went wrong has an outcome instead. Boxed: it is rare,
/// and carries a file where one is shown.
#[derive(Debug)]
pub(super) struct Failure {
    cause: Box<Cause>,
    /// What was done before it, for who wants one document of everything.
    before: Map<String, Value>,
}

#[derive(Debug, thiserror::Error, Diagnostic)]
enum Cause {
    /// A plan, or what it names, cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Prepare(PrepareError),
    /// Something about a run folder.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Folder(RunFolderError),
    /// The arguments do not fit together, or do not fit the plans.
    #[error("{message}")]
    Arguments {
        /// What is wrong.
        message: String,
        /// What to do.
        #[help]
        help: String,
    },
    /// The table cannot be shown.
    #[error("failed to write to the standard output")]
    Output(#[source] io::Error),
    /// A file beside the run folders cannot be written.
    #[error("failed to write {}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A data package cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Data(DatasetError),
    /// A run cannot be made a data set.
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
    Log(LogError),
    /// A bus log makes no run.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Import(ImportError),
    /// The journal of a campaign cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Journal(JournalError),
    /// The account of a campaign cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Account(AccountError),
    /// A campaign cannot go over a server, or no longer.
    #[error(transparent)]
    #[diagnostic(transparent)]
    #[cfg(feature = "nats")]
    Nats(campaign_nats::NatsError),
    /// A case cannot be saved as a plan.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Regression(RegressionError),
    /// A model file cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Model(LibraryError),
    /// The data and the model are what they should be, but not for each other.
    #[error("failed to identify {dataset}")]
    Identify {
        /// Name of the data set.
        dataset: String,
        /// Why.
        source: IdentifyError,
    },
    /// Findings cannot be put into words.
    #[error("failed to write down what was found")]
    Findings(#[source] Box<dyn std::error::Error + Send + Sync>),
    /// Answers to what a person would be asked cannot be used, or are missing.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Answers(AnswersError),
    /// The bench file cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Bench(LibraryError),
    /// The bench does not come up.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Live(harness::world::live::LiveError),
    /// The bench does not fit the plan.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Placement(harness::world::live::PlacementError),
    /// A fault of the plan cannot be injected on the bench.
    #[error(transparent)]
    #[diagnostic(transparent)]
    OutOfReach(harness::world::live::OutOfReach),
    /// What repetitions are asked for can show nothing.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Repetition(campaign::RepetitionError),
    /// The kernel lacks what the lines are to cross.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Kernel(harness::world::crossing::KernelError),
    /// Devices cannot be emulated, or no longer.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Emulation(harness::emulation::EmulationError),
    /// A log cannot be played onto a port, or no longer.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Replay(crate::replay::ReplayError),
    /// A device file cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Devices(harness::world::bench::DevicesError),
    /// Ctrl-C cannot be taken over, and without it no run could be stopped in good order.
    #[error("failed to take over Ctrl-C")]
    Signals(#[source] ctrlc::Error),
}

impl Failure {
    /// Bad arguments: what is wrong, and what to do.
    pub(super) fn arguments(message: impl Into<String>, help: impl Into<String>) -> Self {
        Cause::Arguments { message: message.into(), help: help.into() }.into()
    }

    /// A model file cannot be used.
    pub(super) fn model(error: LibraryError) -> Self {
        Cause::Model(error).into()
    }

    /// The data cannot be identified.
    pub(super) fn identify(dataset: &str, source: IdentifyError) -> Self {
        Cause::Identify { dataset: dataset.to_owned(), source }.into()
    }

    /// What was found cannot be written down.
    pub(super) fn findings(source: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> Self {
        Cause::Findings(source.into()).into()
    }

    /// The standard output cannot be written.
    pub(super) fn output(source: io::Error) -> Self {
        Cause::Output(source).into()
    }

    /// A file beside the run folders cannot be written.
    pub(super) fn file(path: &Path, source: io::Error) -> Self {
        Cause::File { path: path.to_owned(), source }.into()
    }

    /// Ctrl-C cannot be taken over.
    pub(super) fn signals(source: ctrlc::Error) -> Self {
        Cause::Signals(source).into()
    }

    /// Bad input is what the caller can mend by calling differently: a folder that is not ours and a
    /// run that is none are, a disk that is full is not.
    pub(super) const fn exit_status(&self) -> u8 {
        match &*self.cause {
            Cause::Log(error) if !error.is_bad_input() => Outcome::Error.exit_status(),
            Cause::Tables(error) if error.is_bad_input() => EXIT_BAD_INPUT,
            Cause::Prepare(_)
            | Cause::Arguments { .. }
            | Cause::Data(_)
            | Cause::Log(_)
            | Cause::Export(_)
            | Cause::Import(_)
            | Cause::Model(_)
            | Cause::Answers(_)
            | Cause::Bench(_)
            | Cause::Account(AccountError::Foreign { .. } | AccountError::Version { .. })
            | Cause::Journal(JournalError::Other { .. } | JournalError::Broken { .. })
            | Cause::Identify { .. } => EXIT_BAD_INPUT,
            #[cfg(feature = "nats")]
            Cause::Nats(error) if error.is_bad_input() => EXIT_BAD_INPUT,
            Cause::Devices(_)
            | Cause::Placement(_)
            | Cause::OutOfReach(_)
            | Cause::Repetition(_) => EXIT_BAD_INPUT,
            // Where frames were to cross a serial port, or the reverse, nothing is broken.
            Cause::Live(harness::world::live::LiveError::Port(ports::PortError::WrongKind {
                ..
            })) => EXIT_BAD_INPUT,
            Cause::Replay(crate::replay::ReplayError::Port(ports::PortError::WrongKind {
                ..
            })) => EXIT_BAD_INPUT,
            Cause::Kernel(harness::world::crossing::KernelError::NoFrames { .. }) => EXIT_BAD_INPUT,
            Cause::Live(_) | Cause::Kernel(_) | Cause::Emulation(_) | Cause::Replay(_) => {
                Outcome::Error.exit_status()
            }
            Cause::Folder(
                RunFolderError::Foreign { .. }
                | RunFolderError::NoRun { .. }
                | RunFolderError::Read { .. }
                | RunFolderError::Summary { .. }
                | RunFolderError::Record { .. },
            ) => EXIT_BAD_INPUT,
            Cause::Folder(
                RunFolderError::Write { .. }
                | RunFolderError::Remove { .. }
                | RunFolderError::ArtifactName { .. },
            )
            | Cause::Account(AccountError::Io { .. })
            | Cause::Journal(JournalError::Io { .. })
            | Cause::Tables(_)
            | Cause::Mcap(_)
            | Cause::Regression(_)
            | Cause::Output(_)
            | Cause::File { .. }
            | Cause::Findings(_)
            | Cause::Signals(_) => Outcome::Error.exit_status(),
            #[cfg(feature = "nats")]
            Cause::Nats(_) => Outcome::Error.exit_status(),
        }
    }

    /// The same for a build server, with its place where it has one.
    pub(super) fn annotation(&self) -> Annotation {
        let mut labels = self.cause.labels().into_iter().flatten();
        let place = self.cause.source_code().zip(labels.next()).and_then(|(source, label)| {
            let text = source.read_span(label.inner(), 0, 0).ok()?;
            Some((text.name()?.to_owned(), text.line() + 1))
        });
        let help = self.cause.help().map_or_else(String::new, |help| format!("\n{help}"));
        Annotation { place, title: "hil".to_owned(), message: format!("{self}{help}") }
    }

    /// This was done before it.
    pub(super) fn after(mut self, done: Value) -> Self {
        if let Value::Object(done) = done {
            self.before.extend(done);
        }
        self
    }

    /// The same for a program: what was done before, the message, what it is caused by, and what helps.
    pub(super) fn document(&self) -> Value {
        let mut document = self.before.clone();
        let first: &dyn std::error::Error = &*self.cause;
        let causes = std::iter::successors(first.source(), |error| error.source());
        document.insert("error".to_owned(), json!(self.to_string()));
        document
            .insert("causes".to_owned(), causes.map(|cause| json!(cause.to_string())).collect());
        document.insert("help".to_owned(), json!(self.cause.help().map(|help| help.to_string())));
        if let Some((file, line)) = self.annotation().place {
            document.insert("place".to_owned(), json!({ "file": file, "line": line }));
        }
        Value::Object(document)
    }

    /// The message, with the place in the file where there is one: with colours and lines, or in plain
    /// ASCII.
    pub(super) fn rendered(&self, fancy: bool) -> String {
        let theme = if fancy { GraphicalTheme::unicode() } else { GraphicalTheme::none() };
        let handler = GraphicalReportHandler::new_themed(theme).with_width(WIDTH).with_links(fancy);
        let mut text = String::new();
        match handler.render_report(&mut text, &*self.cause) {
            Ok(()) => text,
            Err(_) => format!("{self}\n"),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.cause.fmt(f)
    }
}

impl From<Cause> for Failure {
    fn from(cause: Cause) -> Self {
        Self { cause: Box::new(cause), before: Map::new() }
    }
}

impl From<PrepareError> for Failure {
    fn from(error: PrepareError) -> Self {
        Cause::Prepare(error).into()
    }
}

impl From<DatasetError> for Failure {
    fn from(error: DatasetError) -> Self {
        Cause::Data(error).into()
    }
}

impl From<AnswersError> for Failure {
    fn from(error: AnswersError) -> Self {
        Cause::Answers(error).into()
    }
}

impl From<LogError> for Failure {
    fn from(error: LogError) -> Self {
        Cause::Log(error).into()
    }
}

impl From<ImportError> for Failure {
    fn from(error: ImportError) -> Self {
        match error {
            ImportError::Log(error) => error.into(),
            ImportError::Folder(error) => error.into(),
            error => Cause::Import(error).into(),
        }
    }
}

impl From<ExportError> for Failure {
    fn from(error: ExportError) -> Self {
        match error {
            ExportError::Folder(error) => error.into(),
            ExportError::Data(error) => error.into(),
            error => Cause::Export(error).into(),
        }
    }
}

impl From<TablesError> for Failure {
    fn from(error: TablesError) -> Self {
        match error {
            TablesError::Folder(error) => error.into(),
            error => Cause::Tables(error).into(),
        }
    }
}

impl From<McapExportError> for Failure {
    fn from(error: McapExportError) -> Self {
        match error {
            McapExportError::Folder(error) => error.into(),
            error => Cause::Mcap(error).into(),
        }
    }
}

impl From<RunFolderError> for Failure {
    fn from(error: RunFolderError) -> Self {
        Cause::Folder(error).into()
    }
}

impl From<AccountError> for Failure {
    fn from(error: AccountError) -> Self {
        Cause::Account(error).into()
    }
}

impl From<JournalError> for Failure {
    fn from(error: JournalError) -> Self {
        Cause::Journal(error).into()
    }
}

impl From<RegressionError> for Failure {
    fn from(error: RegressionError) -> Self {
        Cause::Regression(error).into()
    }
}

#[cfg(feature = "nats")]
impl From<campaign_nats::NatsError> for Failure {
    fn from(error: campaign_nats::NatsError) -> Self {
        Cause::Nats(error).into()
    }
}

impl From<LibraryError> for Failure {
    fn from(error: LibraryError) -> Self {
        Cause::Bench(error).into()
    }
}

impl From<harness::emulation::EmulationError> for Failure {
    fn from(error: harness::emulation::EmulationError) -> Self {
        Cause::Emulation(error).into()
    }
}

impl From<crate::replay::ReplayError> for Failure {
    fn from(error: crate::replay::ReplayError) -> Self {
        Cause::Replay(error).into()
    }
}

impl From<harness::world::bench::DevicesError> for Failure {
    fn from(error: harness::world::bench::DevicesError) -> Self {
        Cause::Devices(error).into()
    }
}

impl From<harness::run_live::LiveRunError> for Failure {
    fn from(error: harness::run_live::LiveRunError) -> Self {
        match error {
            harness::run_live::LiveRunError::Folder(error) => error.into(),
            harness::run_live::LiveRunError::Live(error) => Cause::Live(error).into(),
            harness::run_live::LiveRunError::Placement(error) => Cause::Placement(error).into(),
            harness::run_live::LiveRunError::Fault(error) => Cause::OutOfReach(error).into(),
        }
    }
}

impl From<harness::world::live::LiveError> for Failure {
    fn from(error: harness::world::live::LiveError) -> Self {
        Cause::Live(error).into()
    }
}

impl From<harness::world::live::PlacementError> for Failure {
    fn from(error: harness::world::live::PlacementError) -> Self {
        Cause::Placement(error).into()
    }
}

impl From<harness::world::live::OutOfReach> for Failure {
    fn from(error: harness::world::live::OutOfReach) -> Self {
        Cause::OutOfReach(error).into()
    }
}

impl From<campaign::RepetitionError> for Failure {
    fn from(error: campaign::RepetitionError) -> Self {
        Cause::Repetition(error).into()
    }
}

impl From<harness::world::crossing::KernelError> for Failure {
    fn from(error: harness::world::crossing::KernelError) -> Self {
        Cause::Kernel(error).into()
    }
}

#[cfg(test)]
mod tests {
    use super::Failure;
    use harness::run::Prepared;
    use record::run_folder::RunFolderError;

    #[test]
    fn a_full_disk_is_no_bad_input() {
        let source = || std::io::Error::from(std::io::ErrorKind::StorageFull);
        let (path, write) = ("runs/x".into(), source());
        assert_eq!(Failure::from(RunFolderError::Write { path, source: write }).exit_status(), 3);
        assert_eq!(Failure::output(source()).exit_status(), 3);
        let path = "runs/x".into();
        assert_eq!(Failure::from(RunFolderError::Foreign { path }).exit_status(), 2);
    }

    #[test]
    fn the_cause_is_shown() {
        let source = std::io::Error::from(std::io::ErrorKind::StorageFull);
        let failure = Failure::from(RunFolderError::Write { path: "runs/x".into(), source });
        insta::assert_snapshot!(failure.rendered(false));
    }

    #[test]
    fn plain_text_has_no_colours_and_no_lines() {
        let unknown = Prepared::load("varification", &plan::made::Made::default()).unwrap_err();
        let text = Failure::from(unknown).rendered(false);
        assert!(text.is_ascii() && !text.contains('\u{1b}'), "{text}");
    }
}
