//! From a block of equations to the terms that its model lacks.

mod block;
mod choose;
mod cross;
mod data;
mod few;
mod finish;
mod gain;
pub(crate) use gain::fall;
mod held_back;
mod material;
mod means;
mod period;
mod record;
mod refine;
mod rivals;
mod roughly;
mod rounding;
#[cfg(test)]
mod rules;
mod scene;
mod simplify;
mod sound;
mod state;
mod timing;
mod values;

pub use block::{Asked, BlockFit, Found, Waypoint, fit_terms, identify_block};
pub use cross::{Fold, folds};
pub use data::{Data, Memory, combine};
pub use few::fewer;
#[cfg(test)]
pub use rivals::RivalFound;
pub use rounding::without_rounding;
pub use timing::agreed;
