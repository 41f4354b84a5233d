//! From fits to what the contract says: findings, models, predictions, and what a report draws.

mod diagnostics;
mod effects;
mod held_out;
mod predict;

pub(crate) use diagnostics::diagnose;
pub use diagnostics::{BlockDiagnostics, Diagnostics, EffectCurve, RunError, Series};
pub(crate) use effects::{effect, term};
pub(crate) use held_out::{Errors, held_out, path_errors};
pub use predict::predict;
