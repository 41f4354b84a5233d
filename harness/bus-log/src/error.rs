//! Errors of reading and writing a bus log.

use super::Format;
use record::figures;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// Most characters of a text in a message.
const FOUND_CHARS_MAX: usize = 40;

/// Why a bus log cannot be read or written. Everything before the error is good.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum LogError {
    #[error("failed to read {}", path.display())]
    Unreadable { path: PathBuf, source: io::Error },
    #[error("failed to read {} as {}: {place}: {defect}", path.display(), format.name())]
    #[diagnostic(help("{}", help(defect, *good)))]
    Malformed {
        path: PathBuf,
        format: Format,
        place: Place,
        defect: Defect,
        /// Number of entries before it.
        good: u64,
    },
    #[error("failed to read {} as {}: the file is empty", path.display(), format.name())]
    Empty { path: PathBuf, format: Format },
    #[error("failed to write {}", path.display())]
    Unwritable { path: PathBuf, source: io::Error },
    /// A time that the format cannot express.
    #[error("failed to write {}: an entry before 1970 has no place in {}", path.display(), format.name())]
    Before1970 { path: PathBuf, format: Format },
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Line number, from 1.
    Line(u64),
    /// Offset of the block.
    Byte(u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(number) => write!(f, "line {number}"),
            Self::Byte(offset) => write!(f, "block at byte {offset}"),
        }
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Defect {
    expected: &'static str,
    found: String,
    /// The file ends too early.
    is_cut: bool,
    /// What to do about this mistake, where that is known.
    advice: Option<&'static str>,
}

impl Defect {
    /// `found` is shown escaped and shortened.
    pub(super) fn new(expected: &'static str, found: impl AsRef<[u8]>) -> Self {
        let found = found.as_ref();
        // A character takes at most four bytes.
        let shown = &found[..found.len().min(4 * FOUND_CHARS_MAX)];
        let text = String::from_utf8_lossy(shown);
        let mut found: String = text.chars().take(FOUND_CHARS_MAX).collect();
        if found.len() < text.len() {
            found.push_str("...");
        }
        let found = found.escape_debug().to_string();
        Self { expected, found, is_cut: false, advice: None }
    }

    /// At the end of a file that ends too early.
    pub(super) fn cut(self) -> Self {
        Self { is_cut: true, ..self }
    }

    /// With what to do about it.
    pub(super) fn advised(self, advice: &'static str) -> Self {
        Self { advice: Some(advice), ..self }
    }
}

impl fmt::Display for Defect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.found.as_str() {
            "" => write!(f, "expected {}, found nothing", self.expected),
            found => write!(f, "expected {}, found `{found}`", self.expected),
        }
    }
}

fn help(defect: &Defect, good: u64) -> String {
    if let Some(advice) = defect.advice {
        return advice.to_owned();
    }
    let formats = Format::any_name();
    match (good, defect.is_cut) {
        (0, false) => format!("--from {formats} says what the file is"),
        (0, true) => {
            format!(
                "the file seems to be cut short, or of another format: --from {formats} says which"
            )
        }
        (_, is_cut) => {
            let cut = if is_cut { "the file seems to be cut short; " } else { "" };
            let good = figures::counted(good, "entry before that is", "entries before that are");
            format!("{cut}{good} good")
        }
    }
}

impl LogError {
    pub(super) fn unreadable(path: &Path, source: io::Error) -> Self {
        Self::Unreadable { path: path.to_owned(), source }
    }

    pub(super) fn unwritable(path: &Path, source: io::Error) -> Self {
        Self::Unwritable { path: path.to_owned(), source }
    }

    pub(super) fn malformed(path: &Path, format: Format, place: Place, defect: Defect) -> Self {
        Self::Malformed { path: path.to_owned(), format, place, defect, good: 0 }
    }

    pub(super) fn after(mut self, entries: u64) -> Self {
        if let Self::Malformed { good, .. } = &mut self {
            *good = entries;
        }
        self
    }

    /// Whether a file ends too early.
    pub(super) const fn is_cut(&self) -> bool {
        matches!(self, Self::Malformed { defect: Defect { is_cut: true, .. }, .. })
    }

    /// Whether the caller can fix it, because the file is at fault and not the machine.
    pub const fn is_bad_input(&self) -> bool {
        !matches!(self, Self::Unwritable { .. })
    }
}
