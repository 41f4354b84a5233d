//! What is said of a formula at the end of a run.

use wire::time::{Span, Timestamp};

/// Whether a formula held at every moment that could be judged.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// At no moment was it false. With nothing judged this is true too: look at `judged`.
    pub holds: bool,
    /// The least robustness of all judged moments, as a share of the range of what is compared there, or in its unit
    /// where no range is known; positive infinity where nothing was judged.
    pub robustness: f64,
    /// The first moment of that robustness.
    pub worst: Option<Timestamp>,
    /// For how long the formula was true or false.
    pub judged: Span,
    /// For how long it was neither, since a signal had no value.
    pub unknown: Span,
    /// Stretches of moments that the end of the run left open: what was to follow may still have come.
    pub open: u64,
    /// Stretches of moments at which it was false. An edge is one moment, so with
    /// `rises(...) -> ...` it is the number of edges.
    pub violations: u64,
    /// For how long it was false.
    pub violated: Span,
    /// The first of them.
    pub first_violation: Option<Violation>,
}

/// A moment at which a formula was false.
#[derive(Debug, Clone, PartialEq)]
pub struct Violation {
    /// When.
    pub at: Timestamp,
    /// When everything was over that the formula looks at from there: `at` and its horizon, or the end of
    /// the run.
    pub known: Timestamp,
    /// By how much, in the unit of the comparison that decides; zero or negative.
    pub distance: f64,
    /// The signals of the formula at `at`, as the formula names them; not a number is no value.
    pub values: Vec<(String, f64)>,
}

impl Verdict {
    pub(crate) fn new() -> Self {
        Self {
            holds: true,
            robustness: f64::INFINITY,
            worst: None,
            judged: Span::ZERO,
            unknown: Span::ZERO,
            open: 0,
            violations: 0,
            violated: Span::ZERO,
            first_violation: None,
        }
    }
}
