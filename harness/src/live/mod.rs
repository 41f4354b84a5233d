//! The live part: real time and processes.
//!
//! * [`attached`]: a device under test that runs already.
//! * [`command`]: the command line of a device under test, with the names of its ports filled in.
//! * [`lines`]: where the lines of a running rig are, for programs beside it.
//! * [`process`]: a device under test that is a process of its own.

pub mod attached;
pub mod command;
pub mod lines;
pub mod process;
