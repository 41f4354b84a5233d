//! The live part: real time and processes.
//!
//! * [`attached`]: a device under test that runs already.
//! * [`command`]: the command line of a device under test, with the names of its ports filled in.
//! * [`process`]: a device under test that is a process of its own.

pub mod attached;
pub mod command;
pub mod process;
