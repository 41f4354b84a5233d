//! Who can be asked, and what is said where nobody can.

use plan::library::LibraryError;

/// Who can be asked while the run goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Attendance {
    /// A person at a terminal.
    Person,
    /// Nobody, beside a bench in real time: numbers must be given, and what is done by hand attested.
    Nobody,
    /// Nobody, and the bench is simulated: numbers must be given; what is done by hand is done.
    Simulated,
}

/// Why answers cannot be used: bad input.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum AnswersError {
    /// The file cannot be had, or something in it is wrong.
    #[error(transparent)]
    #[diagnostic(transparent)]
    File(#[from] LibraryError),
    /// An argument is wrong.
    #[error("{message}")]
    Argument {
        /// What is wrong.
        message: String,
        /// What to do.
        #[help]
        help: String,
    },
    /// Nobody is there to give what is missing.
    #[error("{what}, and {why}")]
    Missing {
        /// What is missing, in a few words.
        what: String,
        /// Why nobody is.
        why: &'static str,
        /// Each question, and a file that would answer them.
        #[help]
        help: String,
    },
}
