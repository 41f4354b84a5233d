//! Emulated devices on ports, in real time, for any controller: the implementation of `hil emulate`.
//!
//! ```text
//!                     ┌──────────── Emulated (no IO, no clock) ─────────────┐
//!       any program ──┤ line ── gyro ┐ what turns it: the base, the table,   │
//!    by pty, serial   │ line ── base ┘ or, of a gyro alone, a rate           │
//!    port or CAN      │ line ── devices that files describe                  │
//!                     └───────────────────────┬──────────────────────────────┘
//!             requests, a JSON line each, from stdin or a socket (docs/emulators.md)
//! ```
//!
//! Nodes, lines and faults are those of a plan's rig; requests take the place of the plan.
//!
//! * [`mod@emulated`]: the rig, from event to event. `build`: its devices. `tell`: truth and counters.
//! * [`request`]: queries and settings at run time.
//! * [`control`], `outlet`, [`mod@run`]: the shell around it: requests, answers, the real clock, ports.

mod build;
pub mod control;
pub mod emulated;
mod outlet;
pub mod request;
pub mod run;

pub use build::{Parts, Setup, What};
pub use emulated::Emulated;
pub use run::{EmulationError, run};
