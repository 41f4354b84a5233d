//! `all_within` and `never_outside`: the worst value.

use super::figure::{COVERAGE, Figure, Refusal, is_clear};
use super::kind::{Facts, Kind};
use super::selection::{Sample, Selection};
use crate::band::Band;
use schemars::JsonSchema;
use serde::Deserialize;

/// Every value lies in the band.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[schemars(inline)]
pub struct AllWithin(pub Band);

impl Kind for AllWithin {
    fn facts(&self) -> Facts<'_> {
        Facts { value_band: Some(self.0), needs_every_value: true, ..Facts::of(self.0) }
    }

    fn figure(&self, selection: &Selection<'_>) -> Result<Figure, Refusal> {
        worst(&selection.samples(), self.0, "")
    }
}

/// Every value observed during a phase lies in the band, and there is at least one.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[schemars(inline)]
#[serde(deny_unknown_fields)]
pub struct NeverOutside {
    /// The band.
    pub band: Band,
    /// Name or label of a step.
    pub during: String,
}

impl Kind for NeverOutside {
    fn facts(&self) -> Facts<'_> {
        Facts {
            value_band: Some(self.band),
            needs_every_value: true,
            during: Some(&self.during),
            ..Facts::of(self.band)
        }
    }

    fn figure(&self, selection: &Selection<'_>) -> Result<Figure, Refusal> {
        worst(&selection.samples(), self.band, &format!(" during {}", self.during))
    }
}

/// The worst value: by verdict, then by distance to the nearer end of the band, then by magnitude.
fn worst(samples: &[Sample], band: Band, when: &str) -> Result<Figure, Refusal> {
    let rank = |sample: &Sample| {
        let Sample { value, uncertainty } = *sample;
        let badness = (!band.contains(value), !is_clear(value, uncertainty, band, COVERAGE));
        (badness, -band.margin(value))
    };
    let worst = samples.iter().max_by(|a, b| {
        let ((a_badness, a_depth), (b_badness, b_depth)) = (rank(a), rank(b));
        let by_depth = a_badness.cmp(&b_badness).then(a_depth.total_cmp(&b_depth));
        // Of equals the greater, regardless of order.
        by_depth.then(a.value.total_cmp(&b.value))
    });
    let Some(worst) = worst else {
        return Err(Refusal::Unset("no observation".to_owned()));
    };
    let statistic = format!("worst of {}{when}", samples.len());
    Figure::in_band(worst.value, worst.uncertainty, band, statistic)
}
