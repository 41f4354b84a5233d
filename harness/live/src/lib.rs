//! Rigs in real time: the real clock, ports, programs beside this process, and lines through the kernel.
//!
//! * [`mod@world`]: the loop in real time, for a plan. [`emulation`]: the same for any controller (`hil emulate`).
//! * [`at_ports`]: rigs with some nodes at ports of the system.
//! * [`attached`]: a device under test that is already running. [`process`]: one that is started here.
//! * [`command`]: its command line, with the names of its ports filled in. [`lines`]: where the lines of a running rig are, for
//!   programs beside it. [`lease`]: the user of a bench. [`unix_time`]: the date.
//! * [`crossing`]: lines in virtual time that cross the kernel.
//! * `program` (feature `programs`): programs under test in virtual time.

#![allow(
    missing_docs,
    reason = "a crate of this workspace; what others use is documented where `harness` exports it"
)]

pub mod at_ports;
pub mod attached;
pub mod command;
pub mod crossing;
pub mod emulation;
pub mod lease;
pub mod lines;
pub mod process;
#[cfg(feature = "programs")]
pub mod program;
pub mod unix_time;
pub mod world;
