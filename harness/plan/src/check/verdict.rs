//! Verdict on a measurement.

use serde::{Deserialize, Serialize};

/// Verdict on a measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Inside the band by at least the measurement's own expanded uncertainty (k = 2).
    Pass,
    /// Inside the band, by less than the measurement's own expanded uncertainty (k = 2).
    Marginal,
    /// Outside the band.
    Fail,
    /// Declared but never measured. Counts as a failure.
    Unset,
    /// No device of the bench gives it, so that it neither passes nor fails; the statistic says why.
    #[serde(rename = "not_judged")]
    NotJudged,
}

impl Verdict {
    /// Whether a run with this verdict can still pass.
    pub const fn is_acceptable(self) -> bool {
        matches!(self, Self::Pass | Self::Marginal | Self::NotJudged)
    }

    /// Its name, as in `summary.json`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Marginal => "marginal",
            Self::Fail => "fail",
            Self::Unset => "unset",
            Self::NotJudged => "not_judged",
        }
    }

    /// The same for a person.
    pub const fn in_words(self) -> &'static str {
        match self {
            Self::NotJudged => "not judged",
            other => other.name(),
        }
    }
}
