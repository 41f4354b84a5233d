//! Verdict on a measurement.

use serde::{Deserialize, Serialize};

wire::words! {
    /// Verdict on a measurement.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(rename_all = "lowercase")]
    pub enum Verdict {
        /// Inside the band by at least the measurement's own expanded uncertainty (k = 2).
        Pass = "pass",
        /// Inside the band, by less than the measurement's own expanded uncertainty (k = 2).
        Marginal = "marginal",
        /// Outside the band.
        Fail = "fail",
        /// Declared but never measured. Counts as a failure.
        Unset = "unset",
        /// No device of the bench gives it, so that it neither passes nor fails; the statistic says why.
        #[serde(rename = "not_judged")]
        NotJudged = "not_judged",
    }
}

impl Verdict {
    /// Whether a run with this verdict can still pass.
    pub const fn is_acceptable(self) -> bool {
        matches!(self, Self::Pass | Self::Marginal | Self::NotJudged)
    }

    /// The same for a person.
    pub const fn in_words(self) -> &'static str {
        match self {
            Self::NotJudged => "not judged",
            other => other.name(),
        }
    }
}
