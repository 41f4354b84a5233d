//! From a block of equations to the terms that its model lacks.

mod block;
mod choose;
mod cross;
mod data;
mod held_back;
mod means;
mod period;
mod record;
mod refine;
mod rivals;
mod scene;
mod simplify;

pub use block::{BlockFit, Found, fit_terms, identify_block, without_rounding};
pub use cross::folds;
pub use data::{Data, combine};
#[cfg(test)]
pub use rivals::RivalFound;
