//! The figure that a check judges, and how it compares with its band.

use plan::Band;
use record::outcome::Verdict;

/// Expanded uncertainty over standard uncertainty: about 95 % of a normal distribution.
pub(super) const COVERAGE: f64 = 2.0;

/// A figure that was formed.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Figure {
    pub(super) value: f64,
    pub(super) uncertainty: f64,
    pub(super) verdict: Verdict,
    /// What the value is, in words.
    pub(super) statistic: String,
}

/// Why no figure was formed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Refusal {
    /// There is not enough to form it from.
    Unset(String),
    /// What there is cannot be judged.
    Fail(String),
}

impl Figure {
    /// A figure judged on `band` with its own guard band.
    pub(super) fn in_band(
        value: f64,
        uncertainty: f64,
        band: Band,
        statistic: String,
    ) -> Result<Self, Refusal> {
        if !(value.is_finite() && uncertainty.is_finite()) {
            return Err(Refusal::Fail(format!("{statistic}: not a finite number")));
        }
        Ok(Self { value, uncertainty, verdict: verdict(value, uncertainty, band), statistic })
    }
}

/// How a value of this standard uncertainty lies in the band.
pub(super) fn verdict(value: f64, uncertainty: f64, band: Band) -> Verdict {
    graded(band.contains(value), is_clear(value, uncertainty, band, COVERAGE))
}

/// Is `value` inside by at least `coverage` uncertainties? A negative coverage widens the band.
pub(super) fn is_clear(value: f64, uncertainty: f64, band: Band, coverage: f64) -> bool {
    band.margin(value) >= coverage * uncertainty
}

/// Inside the band, and inside the band shrunk by the guard.
pub(super) fn graded(inside: bool, clear: bool) -> Verdict {
    match (inside, clear) {
        (false, _) => Verdict::Fail,
        (true, false) => Verdict::Marginal,
        (true, true) => Verdict::Pass,
    }
}
