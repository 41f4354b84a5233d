//! The values to apply to other data. What is reported keeps the values and errors of the fit under the noise.
//!
//! An effect that the search leaves to slow noise still moves the values of the terms beside it. Weights for slow noise
//! then rest on differences between neighbours, and the level over a whole record suffers; equal weights keep it.
//!
//! An amplitude that was measured once is on average too large, by what its uncertainty adds. Shrunk by it, a wrong cause
//! does less harm, and a right one loses little (James and Stein 1961).

use super::found::BlockFit;
use super::state::State;
use crate::fit::{Found, White, combine, fit_terms, less, robust_fit, values_of};
use crate::judge::Judge;
use crate::noise::NoiseModel;

/// Values to apply of `fit`, whose residual is noise.
pub(super) fn of_noise(fit: &mut BlockFit, state: &State<'_>, judge: &Judge<'_>) {
    let explained = |effect: usize| {
        let (scene, shape) = state.without(state.base + effect);
        scene.score(&shape).statistic
    };
    let shares = (0..fit.effects.len()).map(|effect| (effect, explained(effect)));
    let shares = shares.map(|(effect, square)| share(&fit.effects[effect], square)).collect();
    let even = evener(state, judge);
    let noise = even.as_ref().unwrap_or(&state.noise);
    let mut all = fit.all();
    if even.is_some() {
        for (found, best) in all.iter_mut().zip(fit_terms(state.data, &state.terms, noise)) {
            for (mine, (value, _)) in found.coefficients.iter_mut().zip(best.coefficients) {
                mine.0 = value;
            }
        }
    }
    let effects = all.split_off(state.base);
    // Effects that do not stand for one another lose at most 1 for each number (the square of what is shrunk).
    let most = 2.0 * effects.iter().map(numbers).sum::<f64>();
    fit.applied = apply((all, effects), state, noise, shares, most);
}

/// Values to apply of `fit`, whose residual is not noise: squares come from the errors over runs.
pub(super) fn of_structure(fit: &mut BlockFit, state: &State<'_>) {
    let square = |(value, error): &(f64, f64)| (value / error).powi(2);
    let shares = fit
        .effects
        .iter()
        .map(|found| share(found, found.coefficients.iter().map(square).sum()))
        .collect();
    let most = GROWTH * state.data.block.rows.len() as f64;
    let values = (fit.base.clone(), fit.effects.clone());
    fit.applied = apply(values, state, &state.noise, shares, most);
}

/// Equal weights within a run, if the values that they give predict held-out readings better.
fn evener(state: &State<'_>, judge: &Judge<'_>) -> Option<NoiseModel> {
    if state.data.layout.is_level() || !state.noise.is_coloured() {
        return None;
    }
    let even = NoiseModel { coloured: Vec::new(), ..state.noise.clone() };
    let [weighted, equal] = [&state.noise, &even].map(|noise| judge.judge(&state.terms, noise));
    let mut pairs = weighted.iter().zip(&equal);
    pairs
        .all(|(weighted, equal)| equal.errors.mean_square() < weighted.errors.mean_square())
        .then_some(even)
}

/// Share of an amplitude to apply: noise alone adds 1 to its `square` for each number that was fitted.
fn share(found: &Found, square: f64) -> f64 {
    if square.is_finite() { (1.0 - numbers(found) / square).max(0.0) } else { 1.0 }
}

fn numbers(found: &Found) -> f64 {
    (found.shape.width() + found.shape.nonlinear().len()) as f64
}

/// Growth of the sum of squares, as a share of it, from which effects of a residual that is no noise were needed together.
const GROWTH: f64 = 0.1;

/// Shrinks the effects to these shares, and fits the given model anew beside them. Effects that stand for one another keep
/// their values: each is uncertain because another can take its place, and without all of them the cause is gone. This
/// shows where what is lost is more than `most`, in squares of the noise.
fn apply(
    (base, effects): (Vec<Found>, Vec<Found>),
    state: &State<'_>,
    noise: &NoiseModel,
    shares: Vec<f64>,
    most: f64,
) -> Vec<Found> {
    let whole: Vec<Found> = base.iter().chain(&effects).cloned().collect();
    let shrunk = shrunk(base, effects, state, noise, shares);
    let data = state.data;
    let lost = |columns: &[Vec<f64>], target: &[f64]| {
        let square = |of: &[Found]| -> f64 {
            less(target, &combine(columns, &values_of(of))).iter().map(|left| left * left).sum()
        };
        let before = square(&whole);
        data.block.rows.len() as f64 * (square(&shrunk) - before) / before
    };
    let white = data.whitened(&state.terms, noise);
    // As noise weighs it, and as the error of a prediction is counted.
    let all = [
        lost(&white.columns, &white.target),
        lost(&data.all_columns(&state.terms), &data.block.residual),
    ];
    if all.into_iter().any(|lost| lost > most) { whole } else { shrunk }
}

fn shrunk(
    mut base: Vec<Found>,
    mut effects: Vec<Found>,
    state: &State<'_>,
    noise: &NoiseModel,
    shares: Vec<f64>,
) -> Vec<Found> {
    let data = state.data;
    for (found, share) in effects.iter_mut().zip(shares) {
        found.coefficients.iter_mut().for_each(|(value, _)| *value *= share);
    }
    if !effects.is_empty() {
        let rest = data.left(&state.terms[state.base..], &values_of(&effects));
        let White { whitener, columns, .. } = data.whitened(&state.terms[..state.base], noise);
        let mut values = robust_fit(&columns, &whitener.apply(&rest)).coefficients.into_iter();
        for (value, _) in base.iter_mut().flat_map(|found| &mut found.coefficients) {
            *value = values.next().unwrap_or(*value);
        }
    }
    base.extend(effects);
    base
}

#[cfg(test)]
mod tests {
    use super::share;
    use crate::fit::Found;
    use crate::model::{Acts, Driver, Form, Shape};

    #[test]
    fn an_amplitude_keeps_what_is_beyond_its_uncertainty() {
        let found = |form| Found {
            shape: Shape::new("any", Acts::Bias, Driver::plain("x"), form),
            coefficients: vec![(1.0, 0.2)],
            numbers: Vec::new(),
            strength: 0.0,
            rivals: Vec::new(),
        };
        assert!((share(&found(Form::Linear), 25.0) - 0.96).abs() < 1e-12);
        // A bump has a centre and a width as well.
        assert!((share(&found(Form::Bump), 25.0) - 0.88).abs() < 1e-12);
        assert_eq!(share(&found(Form::Linear), 0.5), 0.0);
        assert_eq!(share(&found(Form::Linear), f64::INFINITY), 1.0);
    }
}
