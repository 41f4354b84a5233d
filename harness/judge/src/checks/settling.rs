//! The time from which on all values stay in a band.

use super::figure::{COVERAGE, Figure, Refusal, graded, is_clear};
use super::select::Point;
use plan::Band;
use wire::time::Span;

/// The time from the first value to the one from which on all are inside. `points` are sorted by time.
pub(super) fn eventually_within(
    points: &[Point],
    band: Band,
    within: Span,
) -> Result<Figure, Refusal> {
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return Err(Refusal::Unset("no observation".to_owned()));
    };
    let settled = |coverage: f64| {
        let clear = |p: &Point| is_clear(p.sample.value, p.sample.uncertainty, band, coverage);
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
        return Err(Refusal::Fail(format!("still outside {band} at the last of {count}")));
    };
    let in_time = |time: Option<f64>| time.is_some_and(|time| time <= within.as_secs_f64());
    let latest = settled(1.0).unwrap_or(last.at - first.at);
    let earliest = settled(-1.0).unwrap_or(value);
    Ok(Figure {
        value,
        uncertainty: (latest - earliest) / 2.0,
        verdict: graded(in_time(Some(value)), in_time(settled(COVERAGE))),
        statistic: format!("time until all of {count} stay {band}"),
    })
}
