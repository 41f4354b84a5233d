//! The terms of a model over a block of equations: their columns, their least-squares fit, and folds of runs that a fit
//! holds out.

mod data;
mod folds;
mod tangent;
mod terms;

pub use data::{Data, Memory, White, combine, less};
pub use folds::{Fold, folds};
pub use tangent::{Number, Tangent};
pub use terms::{Found, RivalFound, RobustFit, fit_terms, residual, robust_fit, values_of};
