//! `eventually_within`: the time from which on all values stay in a band.

use super::figure::{COVERAGE, Figure, Refusal, graded, is_clear};
use super::kind::{Facts, Kind, UnitOf};
use super::selection::{Point, Selection};
use crate::band::Band;
use crate::number;
use schemars::JsonSchema;
use serde::Deserialize;
use wire::time::Span;

/// From some time on every value lies in the band.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[schemars(inline)]
#[serde(deny_unknown_fields)]
pub struct EventuallyWithin {
    /// The band.
    pub band: Band,
    /// The latest such time, counted from the first value.
    #[serde(rename = "within_s", with = "number::DurationOrZero")]
    pub within: Span,
}

impl Kind for EventuallyWithin {
    fn facts(&self) -> Facts<'_> {
        Facts {
            unit: UnitOf::Fixed("s"),
            value_band: Some(self.band),
            ..Facts::of(Band::at_most(self.within.as_secs_f64()))
        }
    }

    fn figure(&self, selection: &Selection<'_>) -> Result<Figure, Refusal> {
        let points = selection.points("time")?;
        let (Some(first), Some(last)) = (points.first(), points.last()) else {
            return Err(Refusal::Unset("no observation".to_owned()));
        };
        let settled = |coverage: f64| {
            let clear =
                |p: &Point| is_clear(p.sample.value, p.sample.uncertainty, self.band, coverage);
            // Values at the same time count together: all must be inside.
            let outside = points.iter().rev().find(|p| !clear(p)).map(|p| p.at);
            let inside = match outside {
                Some(outside) => points.iter().find(|p| p.at > outside),
                None => Some(first),
            };
            inside.map(|p| p.at - first.at)
        };
        let count = points.len();
        let Some(value) = settled(0.0) else {
            return Err(Refusal::Fail(format!(
                "still outside {} at the last of {count}",
                self.band
            )));
        };
        let in_time =
            |time: Option<f64>| time.is_some_and(|time| time <= self.within.as_secs_f64());
        let latest = settled(1.0).unwrap_or(last.at - first.at);
        let earliest = settled(-1.0).unwrap_or(value);
        Ok(Figure {
            value,
            uncertainty: (latest - earliest) / 2.0,
            verdict: graded(in_time(Some(value)), in_time(settled(COVERAGE))),
            statistic: format!("time until all of {count} stay {}", self.band),
        })
    }
}
