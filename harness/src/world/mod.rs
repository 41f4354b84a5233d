//! Worlds: where the plan, the controller and the devices meet.
//!
//! * [`bench`]: the emulated devices of a run, from a device file.
//! * [`simulated`]: virtual time, lines in memory; 16 hours in seconds, the same bytes every time.

pub mod bench;
mod lines;
pub mod simulated;
mod stage;
