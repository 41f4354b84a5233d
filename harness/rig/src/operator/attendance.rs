//! Whether a person can answer during a run, and the error if an answer is missing.

use plan::library::LibraryError;

/// Whether a person can answer during the run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Attendance {
    /// A person at a terminal.
    Person,
    /// No person, on a bench in real time: numbers must be given, and manual work attested.
    Nobody,
    /// No person, on a simulated bench: numbers must be given; manual work counts as done.
    Simulated,
}

/// Why answers cannot be used.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum AnswersError {
    /// The file is missing or invalid.
    #[error(transparent)]
    #[diagnostic(transparent)]
    File(#[from] LibraryError),
    #[error("{message}")]
    Argument {
        message: String,
        #[help]
        help: String,
    },
    /// An answer is missing, and no person is there to give it.
    #[error("{what}, and {why}")]
    Missing {
        /// What is missing, in a few words.
        what: String,
        /// Why no person is there.
        why: &'static str,
        /// Each open question, and a file that would answer them.
        #[help]
        help: String,
    },
}
