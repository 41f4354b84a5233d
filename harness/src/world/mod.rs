//! Worlds: where the plan, the controller and the devices meet.
//!
//! * [`mod@bench`]: the emulated devices of a run, from a device file.
//! * [`simulated`]: virtual time, lines in memory; 16 hours in seconds, the same bytes every time.
//! * [`crossing`]: the same with every packet and frame sent through the kernel on its way.
//! * `live` (feature `live`): the real clock, ptys and ports, the controller as a process of its own.

pub mod bench;
pub mod crossing;
#[cfg(feature = "live")]
pub mod live;
pub(crate) mod watch;
