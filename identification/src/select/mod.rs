//! From a block of equations to the terms that its model lacks.

mod axes;
mod block;
mod choose;
mod cross;
mod data;
mod few;
mod finish;
mod found;
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
mod state;
mod step;
mod timing;
mod values;
mod wheels;

pub use axes::{agreed, is_against};
pub use block::identify_block;
pub use cross::{Fold, folds};
pub use data::{Data, Memory, combine};
pub use few::fewer;
pub use found::{BlockFit, Found, Waypoint, fit_terms};
#[cfg(test)]
pub use rivals::RivalFound;
pub use rounding::without_rounding;
pub use step::Asked;
