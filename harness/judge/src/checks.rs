//! Judges declared measurements, from their observations alone, by the [figures](plan::check) of their checks.
//!
//! If a band was determined with a reference as uncertain as the one used here (`band_holds_reference`), the verdict
//! treats the observations as exact, because their uncertainty is in the band already. The figure is still shown with
//! its uncertainty.
//!
//! An observation that is not finite fails every check that uses it. A figure that cannot be formed is
//! [`Verdict::Unset`], and the statistic states why. The order of the observations does not matter: they are sorted by
//! time, if they have one.

use plan::Declared;
use plan::check::Refusal;
use plan::observation::Observations;
use record::outcome::{Measurement, Outcome, Verdict};

/// Judges every measurement of a plan. [`Outcome::Passed`] if all are acceptable, otherwise [`Outcome::Failed`].
pub fn judge_all(
    declared: &[Declared],
    observations: &Observations,
) -> (Vec<Measurement>, Outcome) {
    let measurements: Vec<_> =
        declared.iter().map(|declared| judge(declared, observations)).collect();
    let outcome = outcome(&measurements);
    (measurements, outcome)
}

/// The outcome of these verdicts. A run in which nothing is judged has not passed.
pub(crate) fn outcome(measurements: &[Measurement]) -> Outcome {
    let passed = measurements.iter().all(|one| one.verdict.is_acceptable());
    let is_judged = |one: &Measurement| one.verdict != Verdict::NotJudged;
    let judged = measurements.is_empty() || measurements.iter().any(is_judged);
    if passed && judged { Outcome::Passed } else { Outcome::Failed }
}

/// Judges one measurement. `observations` may contain other quantities and be in any order.
pub fn judge(declared: &Declared, observations: &Observations) -> Measurement {
    let (check, selection) = (declared.check.kind(), declared.select(observations));
    let facts = check.facts();
    let bounds = facts.figure_band;
    let judged = match selection.complete() {
        // One value outside the band fails the check, however few there are.
        Err(Refusal::Unset(why)) if facts.needs_every_value => match check.figure(&selection) {
            Ok(found) if found.verdict == Verdict::Fail => Ok(found),
            _ => Err(Refusal::Unset(why)),
        },
        complete => complete.and_then(|()| check.figure(&selection)),
    };
    let (value, uncertainty, verdict, statistic) = match judged {
        Ok(found) if declared.band_holds_reference => {
            let exact = check.figure(&selection.taken_as_exact());
            let verdict = exact.map_or(found.verdict, |exact| exact.verdict);
            (Some(found.value), found.uncertainty, verdict, found.statistic)
        }
        Ok(found) => (Some(found.value), found.uncertainty, found.verdict, found.statistic),
        Err(Refusal::Unset(why)) => (None, 0.0, Verdict::Unset, why),
        Err(Refusal::Fail(why)) => (None, 0.0, Verdict::Fail, why),
    };
    Measurement {
        name: declared.name.as_str().to_owned(),
        value,
        unit: declared.unit.clone(),
        lower: bounds.lower(),
        upper: bounds.upper(),
        verdict,
        paper: declared.paper.clone(),
        statistic,
        uncertainty,
        observations: selection.count() as u64,
        proves: declared.proves,
    }
}

#[cfg(test)]
mod tests;
