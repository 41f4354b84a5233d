//! By how much a model lowers the errors on held-out runs, and which of several models to prefer.

use super::choose::simplicity;
use super::state::State;
use crate::judge::{Metric, margin};

/// Fall in the logarithm of an error from which a model is clearly better.
pub(super) const BETTER: f64 = 0.05;

/// The model with the lowest error, or a simpler or a more usual one that is as good beyond the uncertainty of their
/// difference. A number more has to pay as a term more has: one that is not clearly worse without it is as good.
pub(super) fn best_of<'s>(
    judged: Vec<(State<'s>, Vec<Metric>)>,
    before: &[Metric],
) -> Option<(State<'s>, Vec<Metric>)> {
    let numbers = |state: &State<'_>| -> usize {
        state.terms.iter().map(|term| term.width() + term.nonlinear().len()).sum()
    };
    let falls: Vec<f64> = judged.iter().map(|(_, after)| fall(before, after)).collect();
    let most = (0..judged.len()).max_by(|a, b| falls[*a].total_cmp(&falls[*b]))?;
    let as_good = |index: &usize| {
        let (one, best) = (&judged[*index], &judged[most]);
        let saves = numbers(&one.0) < numbers(&best.0) && falls[most] - falls[*index] <= BETTER;
        saves
            || one.1.iter().zip(&best.1).all(|(its, best)| {
                let (more, error) = its.errors.beyond(&best.errors);
                more <= 0.0 || (error.is_finite() && more <= error)
            })
    };
    let usual = |state: &State<'_>| state.terms.last().map_or(0.0, simplicity);
    let chosen = (0..judged.len())
        .filter(as_good)
        .min_by(|a, b| {
            let [one, other] = [a, b].map(|index| &judged[*index].0);
            let usual = || usual(other).total_cmp(&usual(one));
            numbers(one).cmp(&numbers(other)).then_with(usual).then(falls[*b].total_cmp(&falls[*a]))
        })
        .unwrap_or(most);
    judged.into_iter().nth(chosen)
}

/// Sum over the metrics of the logarithm by which the error falls.
pub(crate) fn fall(before: &[Metric], after: &[Metric]) -> f64 {
    before
        .iter()
        .zip(after)
        .map(|(before, after)| {
            (before.errors.rmse() / after.errors.rmse().max(f64::MIN_POSITIVE)).ln()
        })
        .sum()
}

/// Whether the error of some metric falls beyond its uncertainty and in most runs, and none rises beyond its standard
/// error.
pub(super) fn matters(before: &[Metric], after: &[Metric]) -> bool {
    let falls = before.iter().zip(after).any(|(before, after)| {
        let (less, _) = before.errors.beyond(&after.errors);
        less > margin(before, after) && before.errors.share_above(&after.errors) > 0.5
    });
    let rises = before.iter().zip(after).any(|(before, after)| {
        let (more, error) = after.errors.beyond(&before.errors);
        more > error
    });
    falls && !rises
}
