//! Result of a case for a plan without properties, such as one for the user's own device: the plan has to pass.

use crate::campaign::{CaseResult, PASSES, Violated};
use crate::outcome::{Measurement, Outcome};
use crate::run::Ended;
use record::figures;
use std::collections::BTreeMap;

/// Result of a run.
pub(super) fn result(run: &Ended, measurements: &[Measurement], judged: Outcome) -> CaseResult {
    let outcome = run.ending.outcome.max(judged);
    if outcome == Outcome::Aborted {
        return CaseResult::given_up();
    }
    let passed = outcome == Outcome::Passed;
    let broken = measurements.iter().find(|one| !one.verdict.is_acceptable());
    let what = run.ending.reason.clone().or_else(|| broken.map(said)).unwrap_or_default();
    let violated = (!passed).then(|| Violated {
        property: PASSES.to_owned(),
        at_s: run.end.as_secs_f64(),
        what,
    });
    let margin = if run.ending.outcome == Outcome::Passed { least(measurements) } else { -1.0 };
    CaseResult {
        outcome: outcome.name().to_owned(),
        violated: violated.into_iter().collect(),
        margins: BTreeMap::from([(PASSES.to_owned(), margin)]),
        passed,
        announced: run.announced,
        ..CaseResult::default()
    }
}

fn said(measurement: &Measurement) -> String {
    let Measurement { name, statistic, unit, .. } = measurement;
    match measurement.value {
        Some(value) => {
            let limits = [measurement.lower, measurement.upper].into_iter().flatten();
            let figure = figures::quantity_beside(value, 0.0, unit, limits);
            format!("{name}: {statistic}: {figure}")
        }
        None => format!("{name}: {statistic}"),
    }
}

/// The least distance from the end of a band, as a share of half its width, or of its only end: 1 in the middle, 0 at
/// the end, negative outside, within -1 to 1.
fn least(measurements: &[Measurement]) -> f64 {
    let shares = measurements.iter().map(|one| {
        let scale = match (one.lower, one.upper) {
            (Some(lower), Some(upper)) => (upper - lower) / 2.0,
            (end, other) => end.or(other).map_or(0.0, f64::abs),
        };
        match one.margin() {
            None => -1.0,
            Some(margin) if scale > 0.0 => margin / scale,
            Some(margin) => margin,
        }
    });
    shares.fold(1.0, f64::min).max(-1.0)
}

#[cfg(test)]
mod tests {
    use super::{Ended, Outcome, least, result, said};
    use crate::outcome::samples::summary;
    use rig::engine::Ending;

    /// Found by a user: Ctrl-C while a case was made smaller was taken for a break of it.
    #[test]
    fn a_run_that_was_stopped_on_request_breaks_nothing() {
        let ended = |outcome| Ended::at_once(Ending { outcome, reason: None, lost: false });
        let of = |outcome| result(&ended(outcome), &[], Outcome::Passed);
        assert!(of(Outcome::Aborted).violated.is_empty() && of(Outcome::Aborted).is_given_up());
        assert_eq!(of(Outcome::Failed).violated.len(), 1);
    }

    #[test]
    fn a_share_has_no_unit() {
        let mut one = summary().measurements[0].clone();
        (one.value, one.unit) = (Some(0.98984), "1".to_owned());
        assert!(said(&one).ends_with(": 0.9898"), "{}", said(&one));
        one.value = Some(0.984_324_672_535_967_3);
        assert!(said(&one).ends_with(": 0.9843"), "{}", said(&one));
        (one.value, one.unit) = (Some(61.5), "degC".to_owned());
        assert!(said(&one).ends_with(": 61.5 degC"), "{}", said(&one));
    }

    #[test]
    fn the_margin_is_a_share_of_the_band() {
        let mut one = summary().measurements[0].clone();
        (one.lower, one.upper, one.value) = (Some(59.0), Some(61.0), Some(60.0));
        assert_eq!(least(&[one.clone()]), 1.0);
        one.value = Some(61.5);
        assert_eq!(least(&[one.clone()]), -0.5);
        (one.lower, one.upper, one.value) = (None, Some(10.0), Some(7.5));
        assert_eq!(least(&[one.clone()]), 0.25);
        one.value = None;
        assert_eq!(least(&[one]), -1.0);
    }
}
