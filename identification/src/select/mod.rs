//! From a block of equations to the terms that its model lacks.

mod block;
mod choose;
mod finish;
mod found;
mod gain;
mod jointly;
mod limit;
mod material;
mod means;
mod period;
mod record;
mod refine;
mod roughly;
mod scene;
mod simplify;
mod state;
#[cfg(test)]
mod tests;
mod together;
mod values;
mod wheels;

pub use block::identify_block;
pub use choose::Contender;
pub use found::{Asked, BlockFit, Waypoint};
pub(crate) use gain::fall;
pub use together::{agreed, fewer, is_against};
