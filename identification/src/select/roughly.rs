//! Values and errors for a residual that is not noise: least squares, with errors that are valid for any residual if
//! runs are alike (Liang and Zeger 1986).

use super::jointly::Joint;
use super::state::State;
use crate::fit::{Data, Found, White};
use crate::linear::{Normal, dot, solve};
use crate::model::{Form, Shape};
use crate::problem::{clusters, runs};
use crate::significance::surprise;

/// Covariance of least-squares coefficients, and the number of clusters behind it.
fn covariance(
    columns: &[Vec<f64>],
    left: &[f64],
    inverse: &[Vec<f64>],
    cluster: &[usize],
) -> (Vec<Vec<f64>>, usize) {
    let k = columns.len();
    let mut meat = vec![vec![0.0; k]; k];
    let mut count = 0;
    for rows in runs(cluster) {
        let score = |column: &Vec<f64>| dot(&column[rows.clone()], &left[rows.clone()]);
        let scores: Vec<f64> = columns.iter().map(score).collect();
        for a in 0..k {
            for b in 0..k {
                meat[a][b] += scores[a] * scores[b];
            }
        }
        count += 1;
    }
    let factor = count as f64 / (count as f64 - 1.0).max(1.0);
    let times = |a: &[Vec<f64>], b: &[Vec<f64>]| -> Vec<Vec<f64>> {
        (0..k).map(|i| (0..k).map(|j| (0..k).map(|l| a[i][l] * b[l][j]).sum()).collect()).collect()
    };
    let mut found = times(&times(inverse, &meat), inverse);
    found.iter_mut().flatten().for_each(|value| *value *= factor);
    (found, count)
}

/// A least-squares fit of the terms of a state: coefficients, other numbers, and surprise, in nats.
pub(super) struct Estimates {
    pub terms: Vec<Found>,
    /// The residual.
    pub left: Vec<f64>,
}

pub(super) fn estimates(state: &State<'_>) -> Estimates {
    let data = state.data;
    let white = state.whitened();
    let first = Normal::of(&white.columns, &white.target).solve();
    let left = white.left(&first);
    let White { whitener, mut columns, .. } = white;
    let linear = columns.len();
    let mut derivatives = data.derivatives(&state.terms, &first);
    // Without anything that is clipped there is no limit: one that the readings do not tell from its gain makes it no less certain.
    derivatives.retain(|one| state.terms[one.term].form != Form::Saturation);
    columns.extend(derivatives.iter().map(|derivative| whitener.apply(&derivative.column)));
    let (errors, count) = errors(&columns, &left, data);
    let mut terms = Vec::new();
    for (index, (shape, places)) in state.terms.iter().zip(data.places(&state.terms)).enumerate() {
        let coefficients: Vec<(f64, f64)> = places.map(|i| (first[i], errors[i])).collect();
        let numbers = derivatives
            .iter()
            .zip(&errors[linear..])
            .filter(|(derivative, _)| derivative.term == index)
            .map(|(derivative, error)| (derivative.name.to_owned(), *error))
            .collect();
        let found = Found { numbers, ..Found::new(shape, coefficients) };
        terms.push(Found { strength: strength(&found, count), ..found });
    }
    Estimates { terms, left }
}

/// The same of all numbers at their best together.
pub(super) fn estimates_of(joint: &Joint<'_>) -> Estimates {
    let Joint { state, white, left, .. } = joint;
    let (errors, count) = errors(white, left, state.data);
    let mut terms = joint.found(&errors);
    for found in &mut terms {
        found.strength = strength(found, count);
    }
    if !joint.hard.is_empty() {
        // What is missing beyond a limit is known if it is anything at all.
        let beside = estimates(state).terms;
        joint.hard.iter().for_each(|&index| terms[index].strength = beside[index].strength);
    }
    Estimates { terms, left: left.clone() }
}

/// Standard errors of what multiplies each column, with errors clustered by run, and the number of clusters.
fn errors(columns: &[Vec<f64>], left: &[f64], data: Data<'_>) -> (Vec<f64>, usize) {
    let inverse = solve(columns, left).inverse;
    let (covariance, count) = covariance(columns, left, &inverse, &clusters(&data.layout.run));
    ((0..columns.len()).map(|i| covariance[i][i].sqrt()).collect(), count)
}

/// Surprise of the largest deviation of a coefficient from zero, corrected for their number, with errors from so many
/// clusters.
fn strength(found: &Found, clusters: usize) -> f64 {
    let squares = found.coefficients.iter().map(|(value, error)| (value / error).powi(2));
    let wald = squares.filter(|square| square.is_finite()).fold(0.0, f64::max);
    let width = found.coefficients.len().max(1) as f64;
    (surprise(wald, 1.0, clusters as f64 - 1.0) - width.ln()).max(0.0)
}

/// Probability of being zero from which a term is doubtful while others may be missing beside it, whatever its gain on the existing
/// runs; and from which a function is in a model that is reported, beside all that its family tried.
const DOUBTFUL: f64 = 0.01;
/// The same for a constant, the simplest cause: more than one standard error of it, as in the choice on held-out runs; and the risk
/// that any of the constants that a model could have is reported though all are zero.
const CONSTANT_DOUBTFUL: f64 = 0.3;
const CONSTANTS_REPORTED: f64 = 0.05;

/// The added terms that have to be certain by themselves: index and strength. Others only determine the zero of a term.
fn by_themselves(state: &State<'_>) -> Vec<(usize, f64)> {
    let terms = estimates(state).terms;
    let is_zero_of_another = |shape: &Shape| {
        terms.iter().map(|other| &other.shape).any(|other| {
            let is_its_constant = shape.drivers.is_empty() && !other.drivers.is_empty();
            shape.is_lower_order_of(other) || (is_its_constant && shape.acts == other.acts)
        })
    };
    (state.base..terms.len())
        .filter(|&index| !is_zero_of_another(&terms[index].shape))
        .map(|index| (index, terms[index].strength))
        .collect()
}

fn is_constant(state: &State<'_>, index: usize) -> bool {
    state.terms[index].drivers.is_empty()
}

/// The least certain of the added terms that could be zero.
pub(super) fn doubtful(state: &State<'_>) -> Option<usize> {
    let needed = |index: usize| match is_constant(state, index) {
        true => -CONSTANT_DOUBTFUL.ln(),
        false => -DOUBTFUL.ln(),
    };
    let unsure = by_themselves(state).into_iter().filter(|(index, has)| *has < needed(*index));
    Some(unsure.min_by(|a, b| a.1.total_cmp(&b.1))?.0)
}

/// The least certain of the added terms that may not be reported, at a block's `share` of the risk of a false constant.
pub(super) fn unreportable(state: &State<'_>, share: f64) -> Option<usize> {
    let (constants, functions): (Vec<_>, Vec<_>) =
        by_themselves(state).into_iter().partition(|(index, _)| is_constant(state, *index));
    let candidates = state.record.candidates().iter().map(|seen| &seen.candidate.shape);
    let tried = candidates.filter(|shape| shape.drivers.is_empty()).count();
    let needed = |index: usize| state.families[index - state.base].toll(None) - DOUBTFUL.ln();
    let strengths = constants.iter().map(|one| one.1).collect();
    let unsure = if are_certain(strengths, tried, share) { Vec::new() } else { constants };
    let unsure =
        unsure.into_iter().chain(functions.into_iter().filter(|(i, has)| *has < needed(*i)));
    Some(unsure.min_by(|a, b| a.1.total_cmp(&b.1))?.0)
}

/// Whether constants of these strengths are certain among so many that were `tried`, at a `share` of the risk (Holm 1979: the
/// surest against all, the next against those that remain).
fn are_certain(mut strengths: Vec<f64>, tried: usize, share: f64) -> bool {
    strengths.sort_by(|a, b| b.total_cmp(a));
    let needed = |rank: usize| {
        let against = tried.saturating_sub(rank).max(1);
        (against as f64 / (CONSTANTS_REPORTED * share)).ln()
    };
    strengths.iter().enumerate().all(|(rank, has)| *has >= needed(rank))
}

#[cfg(test)]
mod tests {
    use super::{are_certain, clusters, covariance};
    use crate::linear::solve;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn errors_of_a_mean_are_those_of_the_means_of_runs() {
        let run: Vec<usize> = (0..80).map(|i| i / 10).collect();
        let of_run = [1.0, -1.0, 2.0, -2.0, 0.5, -0.5, 1.5, -1.5];
        let y: Vec<f64> = run.iter().map(|&run| of_run[run]).collect();
        let columns = vec![vec![1.0; 80]];
        let fit = solve(&columns, &y);
        let (found, count) = covariance(&columns, &y, &fit.inverse, &clusters(&run));
        // Eight means with a sum of squares of 15: variance 15/7, and an eighth of it for their mean.
        assert_eq!(count, 8);
        assert!((found[0][0] - 15.0 / 7.0 / 8.0).abs() < 1e-12, "{}", found[0][0]);
        assert_eq!(clusters(&[0, 0, 0, 0]).len(), 4);
    }

    /// Four constants that are all zero: one in twenty sets reports any of them.
    #[test]
    fn the_risk_of_a_false_constant_is_that_of_all_that_were_tried() {
        const SETS: usize = 20_000;
        let mut random = chacha20::ChaCha8Rng::seed_from_u64(1);
        let alarms = (0..SETS).filter(|_| {
            let surest = (0..4).map(|_| -random.random::<f64>().ln()).fold(0.0, f64::max);
            are_certain(vec![surest], 4, 1.0)
        });
        let share = alarms.count() as f64 / SETS as f64;
        assert!((share - 0.05).abs() < 0.01, "{share}");
        let strengths = |of: &[f64]| of.iter().map(|p: &f64| -p.ln()).collect::<Vec<f64>>();
        assert!(are_certain(strengths(&[0.016, 0.01]), 4, 1.0));
        assert!(!are_certain(strengths(&[0.016, 0.01]), 4, 0.5));
        assert!(!are_certain(strengths(&[0.02, 0.01]), 4, 1.0));
    }
}
