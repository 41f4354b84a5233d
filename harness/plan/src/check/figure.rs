//! The figure that a check judges, and its comparison with the band.

use super::verdict::Verdict;
use crate::band::Band;

/// Ratio of expanded to standard uncertainty: about 95 % of a normal distribution.
pub(super) const COVERAGE: f64 = 2.0;

/// The figure of a check.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// In the unit of the figure.
    pub value: f64,
    /// Standard uncertainty, in the same unit.
    pub uncertainty: f64,
    /// The comparison with the band.
    pub verdict: Verdict,
    /// Kind of figure, as shown to the user.
    pub statistic: String,
}

/// The reason why there is no figure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Refusal {
    /// There are too few observations.
    Unset(String),
    /// The observations cannot be judged.
    Fail(String),
}

/// Why there is no figure of `count` observations.
pub(super) fn too_few(count: usize, least: usize) -> String {
    match (count, least) {
        (0, 1) => "no observation".to_owned(),
        (1, _) => format!("1 observation, at least {least} are needed"),
        _ => format!("{count} observations, at least {least} are needed"),
    }
}

impl Figure {
    /// A figure judged on `band`, with its own uncertainty as guard band.
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

/// Verdict on a value with this standard uncertainty.
pub(super) fn verdict(value: f64, uncertainty: f64, band: Band) -> Verdict {
    graded(band.contains(value), is_clear(value, uncertainty, band, COVERAGE))
}

/// Whether `value` is inside by at least `coverage` uncertainties. A negative coverage widens the band.
pub(super) fn is_clear(value: f64, uncertainty: f64, band: Band, coverage: f64) -> bool {
    band.margin(value) >= coverage * uncertainty
}

/// Verdict from the comparisons with the band and with the band shrunk by the guard.
pub(super) fn graded(inside: bool, clear: bool) -> Verdict {
    match (inside, clear) {
        (false, _) => Verdict::Fail,
        (true, false) => Verdict::Marginal,
        (true, true) => Verdict::Pass,
    }
}
