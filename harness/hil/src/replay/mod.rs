//! A recorded bus played onto a port in real time, for whatever device listens: what `hil log replay` does.
//!
//! When which frame is due is the business of [`bus_log::replay`], which frames of
//! a log can be sent that of [`bus_log::playable`]. Here are the shell around
//! them (`play`, [`run`]) and what came of it ([`Replayed`]).
//!
//! The timer of the event loop has ticks of 1 ms. It is left [`APPROACH`] before a frame is due; from then
//! on the thread itself sleeps, and turns on the spot for no more than the last
//! [`SPIN_MAX`](live::world::SPIN_MAX) of it.

mod late;
mod play;
mod replayed;
#[cfg(test)]
mod tests;

pub use late::Late;
pub use play::{APPROACH, ReplayError, Setup, play, run};
pub use replayed::{Ending, Replayed};
