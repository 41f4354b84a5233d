//! Emulated devices on ports, in real time, for anybody's controller: what `hil emulate` does.
//!
//! ```text
//!                     ┌────────────── EmulatedBench (no IO, no clock) ──────────────┐
//! anybody's program ──┤ link ── gyro     what turns the gyro: the base, the table,  │
//!    by pty, serial   │ link ── base     or, of a gyro alone, a rate that is set    │
//!    port or CAN      │ link ── table                                               │
//!                     └──────────────────────────┬───────────────────────────────────┘
//!             requests, a JSON line each, from stdin or a socket (docs/emulators.md)
//! ```
//!
//! * [`mod@bench`]: the devices, what carries the gyro, and their links, by the core verbs.
//! * [`link`]: the pace of a line that has none of its own, and the faults of one.
//! * [`request`]: what can be asked and set while it runs. [`tell`]: what is answered.
//! * [`ports`], [`control`], [`mod@run`]: the shell around it: ports, requests, the real clock.

pub mod bench;
pub mod control;
pub mod device;
pub mod link;
pub mod ports;
pub mod request;
pub mod run;
pub mod tell;

pub use bench::{EmulatedBench, Parts};
pub use device::{DeviceSetup, run_device};
pub use run::{EmulationError, Setup, run};

use serde::{Deserialize, Serialize};
use std::fmt;

/// A device that can be emulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// The gyro: a serial line.
    Gyro,
    /// The mobile base: a serial line or a CAN bus.
    Base,
    /// The rotary table: a serial line.
    Table,
}

impl Role {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Gyro, Self::Base, Self::Table];

    /// Its name in requests and answers.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Gyro => "gyro",
            Self::Base => "base",
            Self::Table => "table",
        }
    }
}

impl fmt::Display for Role {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
