//! Why a plan cannot be used: the place in the file, what is wrong there, and what was expected.

use super::hint;
use described::toml_mistake;
use miette::{Diagnostic, NamedSource, SourceSpan};
use std::ops::Range;
use std::sync::Arc;
use thiserror::Error;

/// A mistake in a plan. Rendered by `miette` it shows the line with the place marked.
#[derive(Debug, Clone, Error, Diagnostic)]
#[error("{message}")]
pub struct PlanError {
    message: String,
    #[source_code]
    source_text: Arc<NamedSource<String>>,
    #[label("here")]
    at: SourceSpan,
    #[help]
    help: Option<String>,
}

impl PlanError {
    /// What is wrong, as a lower-case fragment.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// What to do about it, where that is known.
    pub fn advice(&self) -> Option<&str> {
        self.help.as_deref()
    }

    /// Which bytes of the file are meant.
    pub fn range(&self) -> Range<usize> {
        self.at.offset()..self.at.offset() + self.at.len()
    }

    pub(super) fn new(file: &str, text: &str, at: Range<usize>, message: String) -> Self {
        let source = NamedSource::new(file, text.to_owned()).with_language("toml");
        Self { message, source_text: Arc::new(source), at: at.into(), help: None }
    }

    pub(super) fn with_help(mut self, help: Option<String>) -> Self {
        self.help = help;
        self
    }

    pub(super) fn from_toml(file: &str, text: &str, error: &toml::de::Error) -> Self {
        let (at, message) = toml_mistake(text, error);
        let (message, help) = hint::explain(&message);
        Self::new(file, text, at.unwrap_or(0..text.len().min(1)), message).with_help(help)
    }
}
