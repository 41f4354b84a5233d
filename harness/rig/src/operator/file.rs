//! Answers in a file, for unattended runs.
//!
//! ```toml
//! by = "Jane Doe"                 # who answers; goes into the record
//! done = true                     # what is to be done by hand has been done
//!
//! [answers]
//! gap = "1.5 mm"                  # whenever it is asked for
//! mass = ["60 kg", "61.5 kg"]     # the first time, the second time
//! ```

use plan::library::{LibraryError, Source};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use toml::Spanned;

/// Most answers to one question. Assumption: a person reads off fewer in a month.
pub const ANSWERS_MAX: usize = 10_000;

/// An answer file. Its texts are not numbers yet, as only a plan knows their units.
#[derive(Debug, Clone, PartialEq)]
pub struct AnswerFile {
    pub(super) by: String,
    pub(super) done: bool,
    pub(super) answers: BTreeMap<String, Spanned<Written>>,
    source: Source,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Contents {
    by: Spanned<String>,
    #[serde(default)]
    done: bool,
    #[serde(default)]
    answers: BTreeMap<String, Spanned<Written>>,
}

/// Text for one question.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Written {
    /// The same answer each time.
    Always(String),
    /// One answer after the other.
    InTurn(Vec<Spanned<String>>),
}

wire::either! { Written, "a text with a unit such as \"1.5 deg\", or a list of such texts",
    text(text) => Ok(Written::Always(text.to_owned())),
    list(texts) => Vec::deserialize(texts).map(Written::InTurn),
}

impl AnswerFile {
    /// Reads the file.
    ///
    /// # Errors
    /// When the file cannot be read or is invalid.
    pub fn load(path: &Path) -> Result<Self, LibraryError> {
        Self::parse(Source::of_file(path)?)
    }

    pub(super) fn parse(source: Source) -> Result<Self, LibraryError> {
        let Contents { by, done, answers } = source.parse()?;
        if by.get_ref().trim().is_empty() {
            let message = "nobody answers here, expected a name".to_owned();
            return Err(source.mistake(by.span(), message, None));
        }
        for written in answers.values() {
            let count = match written.get_ref() {
                Written::Always(_) => 1,
                Written::InTurn(texts) => texts.len(),
            };
            if !(1..=ANSWERS_MAX).contains(&count) {
                let message = format!("{count} answers, expected 1 to {ANSWERS_MAX}");
                return Err(source.mistake(written.span(), message, None));
            }
        }
        Ok(Self { by: by.into_inner(), done, answers, source })
    }

    /// A mistake that shows only with a plan, with its position in the file.
    pub(super) fn mistake(
        &self,
        at: std::ops::Range<usize>,
        message: String,
        help: Option<String>,
    ) -> LibraryError {
        self.source.mistake(at, message, help)
    }
}
