//! The command `hil`: plans on a bench, from the command line.
//!
//! * [`cli`]: its arguments, its output and its exit status. [`schema`]: the JSON Schemas that editors check files
//!   against.
//! * [`doctor`]: what a machine and a bench lack. [`project`]: the files that `hil new` creates.
//! * [`import`]: reads the log of a bench's CAN bus as a run. [`replay`]: sends a recorded bus to a port.

#![allow(
    missing_docs,
    reason = "a crate of this workspace; what others use is documented where `harness` exports it"
)]

pub mod choices;
pub mod cli;
pub mod doctor;
pub mod import;
pub mod project;
pub mod replay;
pub mod schema;
mod who;
