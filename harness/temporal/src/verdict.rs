//! The verdict on a formula at the end of a run.

use wire::time::{Span, Timestamp};

/// Whether a formula held at every moment that could be judged.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// It was never false. Also true if nothing was judged: see `judged`.
    pub holds: bool,
    /// The smallest robustness of all judged moments, as a share of the range of the comparison, or in its unit if no
    /// range is known; positive infinity if nothing was judged.
    pub robustness: f64,
    /// The first moment with that robustness.
    pub worst: Option<Timestamp>,
    /// Total time during which the formula was true or false.
    pub judged: Span,
    /// Total time during which it was neither, because a signal had no value.
    pub unknown: Span,
    /// Beginning and end of the last stretch of that; the end is exclusive.
    pub unknown_last: Option<(Timestamp, Timestamp)>,
    /// Number of stretches that the end of the run left open: the expected response might still have come.
    pub open: u64,
    /// Number of stretches during which it was false. An edge is one moment, so with `rises(...) -> ...` it is the
    /// number of edges.
    pub violations: u64,
    /// Total time during which it was false.
    pub violated: Span,
    pub first_violation: Option<Violation>,
    /// The first moment that was neither true nor false only because a reading was NaN or infinite.
    pub no_number: Option<NoNumber>,
    /// The text of `a`, if the formula is `a -> b` and `a` was true at no moment at which `b` was known: then nothing was
    /// asked for. Filled at the end of the run.
    pub never_asked: Option<String>,
}

/// A moment at which a formula was false.
#[derive(Debug, Clone, PartialEq)]
pub struct Violation {
    pub at: Timestamp,
    /// When everything that the formula looks at from there is over: `at` plus its horizon, or the end of the run.
    pub known: Timestamp,
    /// The margin in the unit of the deciding comparison; zero or negative.
    pub distance: f64,
    /// That unit, as the formula or its signals name it; empty for pure numbers.
    pub unit: String,
    /// The signals of the formula at `at`, under their names in it; NaN means no value.
    pub values: Vec<(String, f64)>,
    /// Their values at `known`.
    pub last: Vec<f64>,
}

/// A moment that cannot be judged because readings are not finite.
#[derive(Debug, Clone, PartialEq)]
pub struct NoNumber {
    pub at: Timestamp,
    /// The signals with such readings so far, under their names in the formula, and the first reading of each.
    pub readings: Vec<(String, f64)>,
}

impl Verdict {
    pub(crate) fn new() -> Self {
        Self {
            holds: true,
            robustness: f64::INFINITY,
            worst: None,
            judged: Span::ZERO,
            unknown: Span::ZERO,
            unknown_last: None,
            open: 0,
            violations: 0,
            violated: Span::ZERO,
            first_violation: None,
            no_number: None,
            never_asked: None,
        }
    }
}
