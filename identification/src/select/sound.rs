//! Whether the terms of a model make sense beside one another.

use super::scene::robust_fit;
use super::state::State;
use crate::linear::{Solution, solve};
use crate::model::{Form, Shape, is_physical};
use crate::noise::Whitener;

/// Estimates that are so strongly correlated balance one another: one of them is enough.
const CORRELATION_MAX: f64 = 0.98;

/// Is every term that was added within physics, and has every delay settled?
pub(super) fn is_within_physics(state: &State<'_>) -> bool {
    fitted(state).is_some() && delays_have_settled(state)
}

/// Is every term that was added within physics, and does none from `first` on balance another? Where noise is not white,
/// nothing else says that one of the two is enough.
pub(super) fn is_sound(state: &State<'_>, first: usize) -> bool {
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

/// A delay whose coefficient is off its number by more than this share of it would say something else where the model is
/// applied than where it was fitted: there it is a time by which to look back, here a slope.
const SETTLED: f64 = 0.15;

fn is_settled(term: &Shape, coefficients: &[f64]) -> bool {
    let (Form::Delay, Some((_, number)), [value]) = (term.form, term.fixed.first(), coefficients)
    else {
        return true;
    };
    (value - number).abs() <= SETTLED * number.abs()
}

fn delays_have_settled(state: &State<'_>) -> bool {
    if state.terms.iter().all(|term| term.form != Form::Delay) {
        return true;
    }
    // As the delays were found: what is wild counts less.
    let whitener = Whitener::new(state.data.layout, &state.noise, &state.left_out);
    let columns = whitener.apply_all(&state.data.all_columns(&state.terms));
    let fit = robust_fit(&columns, &whitener.apply(&state.data.block.residual));
    let mut coefficients = fit.coefficients.as_slice();
    state.terms.iter().enumerate().all(|(index, term)| {
        let (mine, rest) = coefficients.split_at(state.data.width(term));
        coefficients = rest;
        index < state.base || is_settled(term, mine)
    })
}

/// The fit, and the term of each of its coefficients; `None` where one is outside physics.
fn fitted(state: &State<'_>) -> Option<(Solution, Vec<usize>)> {
    let data = state.data;
    let whitener = Whitener::new(data.layout, &state.noise, &state.left_out);
    let columns = whitener.apply_all(&data.all_columns(&state.terms));
    let fit = solve(&columns, &whitener.apply(&data.block.residual));
    let mut at = 0;
    let mut of_term = Vec::new();
    for (index, term) in state.terms.iter().enumerate() {
        let width = data.width(term);
        of_term.extend(std::iter::repeat_n(index, width));
        let mine = &fit.coefficients[at..at + width];
        at += width;
        let per_row = term.per_row(data.channels).unwrap_or_default();
        if index >= state.base && !is_physical(term, data.channels, &per_row, mine) {
            return None;
        }
    }
    Some((fit, of_term))
}

#[cfg(test)]
mod tests {
    use super::is_settled;
    use crate::model::{Acts, Driver, Form, Shape};

    #[test]
    fn a_delay_that_is_not_its_own_coefficient_has_not_settled() {
        let delay = Shape::new("delay", Acts::Delay, Driver::plain("reference"), Form::Delay)
            .with("delay", 3.4);
        assert!(is_settled(&delay, &[3.3]) && is_settled(&delay, &[3.8]));
        assert!(!is_settled(&delay, &[5.6]) && !is_settled(&delay, &[-3.4]));
        let line =
            Shape::new("any", Acts::Bias, Driver::plain("t"), Form::Linear).with("origin", 1.0);
        assert!(is_settled(&line, &[7.0]));
    }
}
