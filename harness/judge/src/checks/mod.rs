//! Judges declared measurements, from their observations alone.
//!
//! Each check forms one figure from the observations and compares it with its band. A figure inside by less than its
//! expanded uncertainty (k = 2) is [`Verdict::Marginal`]:
//!
//! | figure | its standard uncertainty |
//! |---|---|
//! | worst value | that of the observation |
//! | mean, rms | from the scatter over blocks in time, or the values' own over sqrt(n), whichever is larger |
//! | ratio, correlation | from the same blocks |
//! | slope, intercept | from the scatter about the line or the values' own, whichever is larger |
//! | share, count, time | half the change when every band moves by one standard uncertainty |
//!
//! An uncertainty from a scatter is widened by Student's t, so that k = 2 covers 95 % for few values too.
//!
//! Shares, counts and times are marginal if they pass with the band but fail with the band shrunk by each observation's
//! expanded uncertainty.
//!
//! If a band was determined with a reference as uncertain as the one used here (`band_holds_reference`), the verdict
//! treats the observations as exact, because their uncertainty is in the band already. The figure is still shown with
//! its uncertainty.
//!
//! An observation that is not finite fails every check that uses it. A figure that cannot be formed is
//! [`Verdict::Unset`], and the statistic states why. The order of the observations does not matter: they are sorted by
//! time, if they have one.

mod each;
mod figure;
mod jackknife;
pub mod line;
mod moments;
mod position;
mod select;
mod settling;
pub mod umbmark;

use figure::{Figure, Refusal};
use plan::observation::{Observations, Observed};
use plan::{Check, Declared, quantities};
use record::outcome::{Measurement, Outcome, Verdict};
use select::Selection;

/// Judges every measurement of a plan. [`Outcome::Passed`] if all are acceptable, otherwise [`Outcome::Failed`].
pub fn judge_all(
    declared: &[Declared],
    observations: &Observations,
) -> (Vec<Measurement>, Outcome) {
    let measurements: Vec<_> =
        declared.iter().map(|declared| judge(declared, observations)).collect();
    let passed = measurements.iter().all(|measurement| measurement.verdict.is_acceptable());
    (measurements, if passed { Outcome::Passed } else { Outcome::Failed })
}

/// Judges one measurement. `observations` may contain other quantities and be in any order.
pub fn judge(declared: &Declared, observations: &Observations) -> Measurement {
    let selection = Selection::new(declared, observations);
    let bounds = declared.check.figure_band();
    let judged = selection.complete().and_then(|()| figure(&declared.check, &selection));
    let (value, uncertainty, verdict, statistic) = match judged {
        Ok(found) if declared.band_holds_reference => {
            let exact = figure(&declared.check, &selection.taken_as_exact());
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
        observations: selection.len() as u64,
        proves: declared.proves,
    }
}

fn figure(check: &Check, selection: &Selection<'_>) -> Result<Figure, Refusal> {
    let samples = || selection.samples();
    let together = selection.together();
    match check {
        Check::AllWithin(band) => each::worst(&samples(), *band, ""),
        Check::NeverOutside { band, during } => {
            each::worst(&samples(), *band, &format!(" during {during}"))
        }
        Check::ShareWithin { share, band } => each::share(&samples(), *share, *band),
        Check::AllButWithin { count, band } => each::outside(&samples(), *count, *band),
        Check::AllButInSquare { count, side, centre, .. } => {
            position::outside_square(&selection.positions()?, *count, *side, *centre)
        }
        Check::MeanWithin(band) => moments::mean_within(&samples(), together, *band),
        Check::RmsWithin(band) => moments::rms_within(&samples(), together, *band),
        Check::RmsRatioWithin { band, to_offset, .. } => {
            let second = selection.second_samples();
            moments::ratio_within(&samples(), &second, *to_offset, together, *band)
        }
        Check::SlopeWithin { against, band } => {
            line::slope_within(&selection.points(against)?, *band)
        }
        Check::InterceptWithin { against, band } => {
            line::intercept_within(&selection.points(against)?, *band)
        }
        Check::CorrelationWithin { against, band } => {
            line::correlation_within(&selection.points_in_time(against)?, together, *band)
        }
        Check::EventuallyWithin { band, within } => {
            settling::eventually_within(&selection.points("time")?, *band, *within)
        }
        Check::UmbmarkWithin { figure, side, band, .. } => {
            umbmark::within(&selection.positions()?, *figure, *side, *band)
        }
    }
}

/// Whether this was observed during the phase, which is a step's name or label.
fn is_during(observed: &Observed<'_>, phase: &str) -> bool {
    observed.tag(&quantities::during_tag(phase)).is_some_and(|value| value != 0.0)
}

#[cfg(test)]
mod tests;
