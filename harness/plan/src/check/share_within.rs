//! `share_within`: the share of the values in a band. Of times between messages it is the share of the time, so that one
//! long silence weighs as much as the messages that are missing.

use super::figure::{COVERAGE, Figure, Refusal, graded, is_clear};
use super::kind::{Facts, Kind, UnitOf};
use super::selection::{Sample, Selection};
use crate::band::Band;
use crate::number;
use schemars::JsonSchema;
use serde::Deserialize;

/// At least a share of the values lies in the band; of the time between messages, at least a share of the time.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[schemars(inline)]
#[serde(deny_unknown_fields)]
pub struct ShareWithin {
    /// The least share.
    #[serde(with = "number::Share")]
    pub share: f64,
    /// The band.
    pub band: Band,
}

impl Kind for ShareWithin {
    fn facts(&self) -> Facts<'_> {
        Facts {
            unit: UnitOf::Fixed("1"),
            value_band: Some(self.band),
            ..Facts::of(Band::at_least(self.share))
        }
    }

    fn figure(&self, selection: &Selection<'_>) -> Result<Figure, Refusal> {
        let samples = selection.samples();
        let count = samples.len();
        // Without any time between them, all messages count alike.
        let by_time = selection.are_periods() && samples.iter().map(|s| s.value).sum::<f64>() > 0.0;
        let weight = |s: &Sample| if by_time { s.value } else { 1.0 };
        let all: f64 = samples.iter().map(weight).sum();
        let share = |coverage: f64| {
            let clear = |s: &&Sample| is_clear(s.value, s.uncertainty, self.band, coverage);
            samples.iter().filter(clear).map(weight).sum::<f64>() / all
        };
        let value = share(0.0);
        Ok(Figure {
            value,
            uncertainty: (share(-1.0) - share(1.0)) / 2.0,
            verdict: graded(value >= self.share, share(COVERAGE) >= self.share),
            statistic: match selection.are_periods() {
                true => format!("share of the time of {count} periods inside {}", self.band),
                false => format!("share of {count} inside {}", self.band),
            },
        })
    }
}
