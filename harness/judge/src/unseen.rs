//! Measurements of what no device of the bench gives: the truth of a real base.

use crate::checks::outcome;
use plan::Declared;
use plan::quantities::OF_TRUTH;
use record::outcome::{Measurement, Outcome, Verdict};

/// Whether a measurement needs the true pose of the base.
pub fn needs_truth(declared: &Declared) -> bool {
    let second = declared.check.kind().facts().second_quantity.map(|(_, name)| name.as_str());
    let names = [Some(declared.quantity.as_str()), second];
    names.into_iter().flatten().any(|name| OF_TRUTH.iter().any(|known| known.name == name))
}

/// Takes back the verdict on measurements of the truth where the truth is not known, for the reason `why`, and returns
/// the outcome of all of them.
pub fn without_truth(
    declared: &[Declared],
    measurements: &mut [Measurement],
    why: &str,
) -> Outcome {
    for (declared, measurement) in declared.iter().zip(&mut *measurements) {
        if measurement.verdict == Verdict::Unset && needs_truth(declared) {
            measurement.verdict = Verdict::NotJudged;
            why.clone_into(&mut measurement.statistic);
        }
    }
    outcome(measurements)
}

#[cfg(test)]
mod tests {
    use super::{needs_truth, without_truth};
    use crate::checks::judge_all;
    use plan::Plan;
    use plan::observation::Observations;
    use record::outcome::{Outcome, Verdict};

    const PLAN: &str = include_str!("../../../test-plans/turn-accuracy.toml");

    #[test]
    fn a_truth_that_nobody_sees_neither_passes_nor_fails() {
        let plan = Plan::parse("turn-accuracy", PLAN).unwrap();
        let (mut measurements, judged) = judge_all(&plan.measurements, &Observations::default());
        assert_eq!(judged, Outcome::Failed);
        let again = |measurements: &mut Vec<_>| {
            without_truth(&plan.measurements, measurements, "the base is real")
        };
        assert_eq!(again(&mut measurements), Outcome::Failed, "others were never measured");
        for (declared, measurement) in plan.measurements.iter().zip(&mut measurements) {
            let is_truth = declared.name.as_str().starts_with("true_");
            assert_eq!(needs_truth(declared), is_truth, "{}", measurement.name);
            let expected = if is_truth { Verdict::NotJudged } else { Verdict::Unset };
            assert_eq!(measurement.verdict, expected, "{}", measurement.name);
            assert_eq!(measurement.statistic == "the base is real", is_truth);
            if !is_truth {
                measurement.verdict = Verdict::Pass;
            }
        }
        assert_eq!(again(&mut measurements), Outcome::Passed);
        measurements.iter_mut().for_each(|one| one.verdict = Verdict::NotJudged);
        assert_eq!(again(&mut measurements), Outcome::Failed, "nothing was judged");
    }

    #[test]
    fn a_truth_that_was_seen_keeps_its_verdict() {
        let plan = Plan::parse("turn-accuracy", PLAN).unwrap();
        let (mut measurements, _) = judge_all(&plan.measurements, &Observations::default());
        measurements.iter_mut().for_each(|one| one.verdict = Verdict::Fail);
        let judged = without_truth(&plan.measurements, &mut measurements, "the gyro is real");
        assert_eq!(judged, Outcome::Failed);
        assert!(measurements.iter().all(|one| one.verdict == Verdict::Fail));
    }
}
