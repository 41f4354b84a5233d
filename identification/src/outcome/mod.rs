//! Turns fits into the output of the contract: findings, models, predictions and report data.

mod diagnostics;
mod effects;
mod path;
mod phrases;
mod polynomial;
mod predict;
mod sentence;
mod unmended;
mod whiteness;
mod words;

use crate::select::{Data, Found, combine};
pub(crate) use diagnostics::diagnose;
pub use diagnostics::{BlockDiagnostics, Diagnostics, EffectCurve, RunError, Series};
pub(crate) use effects::{effect, lines_before_their_zero, term};
pub(crate) use path::path;
pub(crate) use polynomial::join_powers;
pub(crate) use predict::{is_of_kind, predict};
pub(crate) use unmended::{OffsetOfRuns, offset_of_runs, rounding, slow_noise};
pub use whiteness::{WHITENESS_LEVEL, Whiteness};
pub(crate) use whiteness::{of_innovations, stretches, whiteness};

/// Residual of a block after `found`, in SI.
fn residual(data: Data<'_>, found: &[Found]) -> Vec<f64> {
    let mut left = data.block.residual.clone();
    for found in found {
        let coefficients: Vec<f64> = found.coefficients.iter().map(|(value, _)| *value).collect();
        let fitted = combine(&data.columns(&found.shape), &coefficients);
        for (value, fitted) in left.iter_mut().zip(&fitted) {
            *value -= fitted;
        }
    }
    left
}
