//! Plays a recorded bus to a port in real time, for any listening device: `hil log replay`.
//!
//! [`bus_log::replay`] decides when each frame is due, [`bus_log::playable`] which frames of a log can be sent. This
//! module contains the shell around them (`play`, [`run`]) and the result ([`Replayed`]).
//!
//! The timer of the event loop has ticks of 1 ms. It ends [`APPROACH`] before a frame is due; from then on the thread
//! itself sleeps, and spins for no more than the last [`SPIN_MAX`](live::world::SPIN_MAX) of it.

mod late;
mod play;
mod replayed;
#[cfg(test)]
mod tests;

pub use late::Late;
pub use play::{APPROACH, ReplayError, Setup, play, run};
pub use replayed::{Ending, Replayed};
