//! The command `hil`: plans on a bench, from the command line.
//!
//! * [`cli`]: its arguments, what it says and its exit status. [`schema`]: what editors check files by.
//! * [`doctor`]: what a machine and a bench lack. [`project`]: what `hil new` makes.
//! * [`import`]: the log of a bench's CAN bus as a run. [`replay`]: a recorded bus onto a port.

pub mod cli;
pub mod doctor;
pub mod gyro_arguments;
pub mod import;
pub mod project;
pub mod replay;
pub mod schema;
mod who;
