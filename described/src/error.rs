//! Mistakes in files written by users: the place, the problem, and the remedy.

use crate::hint;
use crate::place::Place;
use crate::toml_mistake::toml_mistake;
use miette::{Diagnostic, NamedSource, SourceSpan};
use std::ops::Range;
use std::sync::Arc;
use thiserror::Error;

/// A mistake in a plan, a description or another file written by users. `miette` renders it with the line and the
/// marked place.
#[derive(Debug, Clone, Error, Diagnostic)]
#[error("{message}")]
pub struct FileError {
    message: String,
    #[source_code]
    source_text: Arc<NamedSource<String>>,
    #[label("here")]
    at: SourceSpan,
    #[help]
    help: Option<String>,
}

impl FileError {
    /// The problem, as a lower-case fragment.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// The remedy, if known.
    pub fn advice(&self) -> Option<&str> {
        self.help.as_deref()
    }

    /// The file with the mistake.
    pub fn file(&self) -> &str {
        self.source_text.name()
    }

    /// The bytes of the file with the mistake.
    pub fn range(&self) -> Range<usize> {
        self.at.offset()..self.at.offset() + self.at.len()
    }

    /// A mistake at the bytes `at` of `text`, the content of `file`.
    pub fn new(file: &str, text: &str, at: Range<usize>, message: String) -> Self {
        let source_text = Arc::new(NamedSource::new(file, text.to_owned()));
        Self { message, source_text, at: at.into(), help: None }
    }

    /// Adds the remedy.
    #[must_use]
    pub fn with_help(mut self, help: Option<String>) -> Self {
        self.help = help;
        self
    }

    /// An error of `toml` in `text`, as a readable mistake.
    pub fn from_toml(file: &str, text: &str, error: &toml::de::Error) -> Self {
        let (at, message) = toml_mistake(text, error);
        let (message, help) = hint::explain(&message);
        Self::new(file, text, at.unwrap_or(0..text.len().min(1)), message).with_help(help)
    }
}

/// Something read from a file, or the first mistake in it.
pub(crate) type Read<T = ()> = Result<T, Mistake>;

/// A mistake whose place is given as a path in the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mistake {
    pub(crate) place: Place,
    /// The problem, as a lower-case fragment.
    pub message: String,
    /// The remedy, if known.
    pub help: Option<String>,
}

impl Place {
    /// A mistake at this place.
    pub fn mistake(&self, message: impl Into<String>) -> Mistake {
        Mistake::new(self.clone(), message)
    }
}

impl Mistake {
    pub(crate) fn new(place: Place, message: impl Into<String>) -> Self {
        Self { place, message: message.into(), help: None }
    }

    /// Adds the remedy.
    #[must_use]
    pub fn help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }

    /// Adds the remedy, if known.
    #[must_use]
    pub fn with_help(self, help: Option<String>) -> Self {
        Self { help, ..self }
    }

    /// The mistake in the file with this name and text.
    pub fn located(self, file: &str, text: &str) -> FileError {
        let at = self.place.locate(text);
        FileError::new(file, text, at, self.message).with_help(self.help)
    }
}
