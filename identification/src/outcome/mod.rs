//! Turns fits into the output of the contract: findings, models, predictions and report data.

mod delay;
mod diagnostics;
mod effects;
mod phrases;
mod polynomial;
mod predict;
mod sentence;
mod unmended;
mod words;
pub use crate::judge::{WHITENESS_LEVEL, Whiteness};
pub(crate) use diagnostics::diagnose;
pub use diagnostics::{BlockDiagnostics, Diagnostics, EffectCurve, RunError, Series};
pub(crate) use effects::{effect, lines_before_their_zero, path, term};
pub(crate) use polynomial::join_powers;
pub(crate) use predict::{is_of_kind, predict};
pub(crate) use unmended::{OffsetOfRuns, offset_of_runs, rounding, slow_noise};
