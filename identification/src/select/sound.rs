//! Whether the terms of a model make sense beside one another.

use super::state::State;
use crate::linear::solve;
use crate::model::is_physical;
use crate::noise::Whitener;

/// Estimates that are so strongly correlated balance one another: one of them is enough.
const CORRELATION_MAX: f64 = 0.98;

/// Is every term that was added within physics, and does none from `first` on balance another?
pub(super) fn is_sound(state: &State<'_>, first: usize) -> bool {
    let data = state.data;
    let whitener = Whitener::new(data.layout, &state.noise, &state.left_out);
    let columns = whitener.apply_all(&data.all_columns(&state.terms));
    let fit = solve(&columns, &whitener.apply(&data.block.residual));
    let mut at = 0;
    let mut of_term = Vec::new();
    for (index, term) in state.terms.iter().enumerate() {
        let width = data.columns(term).len();
        of_term.extend(std::iter::repeat_n(index, width));
        let mine = &fit.coefficients[at..at + width];
        at += width;
        let per_row = term.per_row(data.channels).unwrap_or_default();
        if index >= state.base && !is_physical(term, data.channels, &per_row, mine) {
            return false;
        }
    }
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
