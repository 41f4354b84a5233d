//! What a rig stands on: the emulated devices of the paper's robot, the kernel that lines may cross, ports and the real clock.
//!
//! * [`mod@bench`]: the emulated devices of a run, from a device file.
//! * [`crossing`]: virtual time with every packet and frame sent through the kernel on its way.
//! * `live` (feature `live`): the real clock, ptys and ports, programs under test.

pub mod bench;
pub mod crossing;
#[cfg(feature = "live")]
pub mod live;
pub(crate) mod watch;
