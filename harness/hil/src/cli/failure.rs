//! Why a command could not do its work: for people, programs and build servers.

mod cause;
mod wide;

use super::annotation::Annotation;
use super::tame;
use cause::{Cause, OwnCause};
use harness::run_live::LiveRunError;
use identification::identify::IdentifyError;
use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme};
use serde_json::{Map, Value, json};
use std::borrow::Cow;
use std::path::Path;
use std::{fmt, io};

/// Line width of a message; longer lines are hard to read.
const WIDTH: usize = 100;

/// Why a command did not do its work. A failed run has an outcome instead. Boxed, since it is rare and may hold a whole
/// file.
#[derive(Debug)]
pub(super) struct Failure {
    cause: Box<dyn Cause>,
    /// Results so far, for users who want one document of everything.
    before: Map<String, Value>,
}

impl Failure {
    /// Bad arguments: what is wrong, and how to fix it.
    pub(super) fn arguments(message: impl Into<String>, help: impl Into<String>) -> Self {
        OwnCause::Arguments { message: message.into(), help: help.into() }.into()
    }

    /// The data cannot be identified, with the model of this file if given.
    pub(super) fn identify(dataset: &str, model: Option<&Path>, source: IdentifyError) -> Self {
        let model = model.map(Path::to_owned);
        OwnCause::Identify { dataset: dataset.to_owned(), model, source }.into()
    }

    pub(super) fn findings(source: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> Self {
        OwnCause::Findings(source.into()).into()
    }

    pub(super) fn output(source: io::Error) -> Self {
        OwnCause::Output(source).into()
    }

    /// A file beside the run folders cannot be written.
    pub(super) fn file(path: &Path, source: io::Error) -> Self {
        OwnCause::File { path: path.to_owned(), source }.into()
    }

    /// The handler of Ctrl-C cannot be installed.
    pub(super) fn signals(source: ctrlc::Error) -> Self {
        OwnCause::Signals(source).into()
    }

    pub(super) fn exit_status(&self) -> u8 {
        self.cause.exit_status()
    }

    /// Converts the failure for a build server, with its location if known.
    pub(super) fn annotation(&self) -> Annotation {
        let mut labels = self.cause.labels().into_iter().flatten();
        let place = self.cause.source_code().zip(labels.next()).and_then(|(source, label)| {
            let text = source.read_span(label.inner(), 0, 0).ok()?;
            Some((text.name()?.to_owned(), text.line() + 1))
        });
        let help = self.cause.help().map_or_else(String::new, |help| format!("\n{help}"));
        Annotation { place, title: "hil".to_owned(), message: format!("{self}{help}") }
    }

    /// Adds the results so far.
    pub(super) fn after(mut self, done: Value) -> Self {
        if let Value::Object(done) = done {
            self.before.extend(done);
        }
        self
    }

    /// Converts the failure for a program: results so far, message, causes and help.
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

    /// Formats the message, with an excerpt of the file if there is one: with colours and lines, or in plain ASCII.
    pub(super) fn rendered(&self, fancy: bool) -> String {
        // Text from a file is shown as text: if it contains control characters, the message has no colours.
        let plain = self.drawn(false);
        match tame::plain(&plain) {
            Cow::Borrowed(_) if fancy => self.drawn(true),
            text => text.into_owned(),
        }
    }

    fn drawn(&self, fancy: bool) -> String {
        let theme = if fancy { GraphicalTheme::unicode() } else { GraphicalTheme::none() };
        let handler = GraphicalReportHandler::new_themed(theme).with_width(WIDTH).with_links(fancy);
        let mut text = String::new();
        let bare;
        let shown: &dyn Diagnostic = match wide::is_too_wide(&*self.cause) {
            true => {
                bare = wide::Bare { shown: &*self.cause, place: self.annotation().place };
                &bare
            }
            false => &*self.cause,
        };
        match handler.render_report(&mut text, shown) {
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

impl<E: Cause> From<E> for Failure {
    fn from(error: E) -> Self {
        Self { cause: Box::new(error), before: Map::new() }
    }
}

impl From<LiveRunError> for Failure {
    fn from(error: LiveRunError) -> Self {
        match error {
            LiveRunError::Folder(error) => error.into(),
            LiveRunError::Live { source, .. } => (*source).into(),
            LiveRunError::Placement(error) => error.into(),
            LiveRunError::Unfit(error) => error.into(),
        }
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
