//! Checks that the terms of a model make sense together.

use super::State;
use crate::fit::White;
use crate::linear::{Solution, coefficients, solve};
use crate::model::{Acts, Form, Shape, Wrap, is_delay, is_physical};

/// Correlation above which estimates balance one another: one of them is enough.
const CORRELATION_MAX: f64 = 0.98;

/// Whether every added term is physical.
pub fn is_within_physics(state: &State<'_>) -> bool {
    fitted(state).is_some()
}

/// Whether every added term is physical, and none from `first` on balances another. If noise is not white, nothing else
/// shows that one of the two is enough.
pub fn is_sound(state: &State<'_>, first: usize) -> bool {
    let Some((fit, of_term)) = fitted(state) else { return false };
    for i in (0..of_term.len()).filter(|&i| of_term[i] >= first) {
        for j in (0..of_term.len()).filter(|&j| of_term[j] < first) {
            let scale = (fit.inverse[i][i] * fit.inverse[j][j]).sqrt();
            if !(scale > 0.0) || (fit.inverse[i][j] / scale).abs() > CORRELATION_MAX {
                return false;
            }
        }
    }
    true
}

/// Rounds in which numbers settle, the change from which they begin to, and the one from which one has not.
const ROUNDS: usize = 10;
const ASTRAY: f64 = 0.1;
const SETTLED: f64 = 1e-3;
/// Share of what is measured from which a delay of more than a sample moves it by its number, and not by its coefficient.
const MOST: f64 = 0.5;

/// Sets the number of each lag and delay to its coefficient beside the other terms, if that is not a share of what is late by more
/// than a sample: a model that is written down has one for both. Returns whether any has changed.
pub fn settle(state: &mut State<'_>) -> bool {
    if !state.terms[state.base..].iter().any(|term| matches!(term.form, Form::Delay)) {
        return false;
    }
    let mut has_changed = false;
    for _ in 0..ROUNDS {
        let data = state.data;
        let White { columns, target, .. } = state.whitened();
        let found = coefficients(&columns, &target);
        let places = data.places(&state.terms);
        let most = if has_changed { SETTLED } else { ASTRAY };
        let mut is_settled = true;
        for (term, places) in state.terms.iter_mut().zip(places).skip(state.base) {
            let first = term.fixed.first().cloned();
            let Some((name, now)) = first.filter(|_| matches!(term.form, Form::Delay)) else {
                continue;
            };
            let by = found[places.start] / now;
            let is_long = data.by_delay(term).is_some();
            let next = match is_long {
                true if by >= MOST => 1.0,
                true => by,
                false => by.clamp(0.5, 2.0),
            };
            if next.is_finite() && next != 0.0 && (next - 1.0).abs() > most {
                term.set(&name, next * now);
                (is_settled, has_changed) = (false, true);
            }
        }
        if is_settled {
            break;
        }
    }
    has_changed
}

/// Whether one of `terms` is a lag of what is measured.
fn lags(terms: &[Shape]) -> bool {
    let is_lag = |term: &Shape| {
        term.acts == Acts::Delay && term.drivers.iter().any(|driver| driver.wrap == Wrap::LagOf)
    };
    terms.iter().any(is_lag)
}

/// The fit, and the term of each of its coefficients; `None` if one is unphysical.
fn fitted(state: &State<'_>) -> Option<(Solution, Vec<usize>)> {
    let data = state.data;
    let White { columns, target, .. } = state.whitened();
    let fit = solve(&columns, &target);
    let mut of_term = Vec::new();
    let lags = lags(&state.terms[state.base..]);
    for (index, (term, places)) in state.terms.iter().zip(data.places(&state.terms)).enumerate() {
        of_term.extend(std::iter::repeat_n(index, places.len()));
        let mine = &fit.coefficients[places];
        let is_given = index < state.base;
        let per_row = || term.per_row(data.channels).unwrap_or_default();
        if !is_given && !is_physical(term, data.channels, &per_row(), mine) {
            return None;
        }
        // What follows slowly does not come early: a lead gives back what the lag takes too much.
        if lags && is_delay(term) && mine.iter().any(|delay| *delay < 0.0) {
            return None;
        }
    }
    Some((fit, of_term))
}
