//! Emulated devices on ports, in real time, for anybody's controller: what `hil emulate` does.
//!
//! ```text
//!                     ┌──────────── Emulated (no IO, no clock) ─────────────┐
//! anybody's program ──┤ line ── gyro ┐ what turns it: the base, the table,   │
//!    by pty, serial   │ line ── base ┘ or, of a gyro alone, a rate           │
//!    port or CAN      │ line ── devices that files describe                  │
//!                     └───────────────────────┬──────────────────────────────┘
//!             requests, a JSON line each, from stdin or a socket (docs/emulators.md)
//! ```
//!
//! Nodes, lines and faults are those of a plan's rig; requests stand where the plan stands in a run.
//!
//! * [`mod@emulated`]: the rig, from event to event. `build`: what is on it. `tell`: what is true, and what was counted.
//! * [`request`]: what can be asked and set while it runs.
//! * [`control`], `outlet`, [`mod@run`]: the shell around it: requests, answers, the real clock, ports.

mod build;
pub mod control;
pub mod emulated;
mod outlet;
pub mod request;
pub mod run;
mod tell;

pub use build::{Parts, What};
pub use emulated::Emulated;
pub use run::{EmulationError, Setup, run};
