//! The live part: real time, ptys and processes.
//!
//! * [`command`]: the command line of a device under test, with the names of its ports filled in.
//! * [`process`]: a device under test that is a process of its own.
//! * [`pty`]: a serial port that another process can open.

pub mod command;
pub mod process;
pub mod pty;
