//! Runs test plans on a bench of CAN and serial devices, simulated or real, and judges them.
//!
//! # In your own tests
//!
//! [`Trial`] is all that a `cargo test` needs: it runs a plan in virtual time, with emulated devices and optionally
//! with [your own controller](HostedController). Virtual time needs no feature:
//!
//! ```toml
//! [dev-dependencies]
//! harness = { path = "...", default-features = false }
//! ```
//!
//! ```
//! use harness::{Trial, TrialError};
//!
//! // In a test: #[test] fn turns_stay_within_the_band() -> Result<(), TrialError> {
//! let run = Trial::load("live-table-run")?.with_seed(2).run()?;
//! assert!(run.passed(), "{run}");           // prints each figure with its band, and where the run folder is
//!
//! let findings = Trial::load("live-table-run")?.campaign().faults(&["drop"]).cases(10).run()?;
//! assert!(findings.held(), "{findings}");   // prints the smallest case that breaks it, as a plan
//! # Ok::<(), TrialError>(())
//! ```
//!
//! See [`trial`] for details; `examples/rust-tests` is a crate with its own controller and tests.
//!
//! # Structure
//!
//! ```text
//!  plan.toml ──> plan ──> engine ───> rig ───> record ──> checks ──> summary, report, JUnit
//!  device file ─────────────────────┘  └ controller, gyro, base, table, absolute measurement
//! ```
//!
//! A plan defines steps and verdicts. The engine carries it out: missions to the controller (the device under test),
//! commands to the table, queries to the absolute measurement. A rig connects engine, controller and devices; in
//! virtual time the clock jumps from event to event and the bytes are those of real lines. Everything is recorded, and
//! checks and reports read only the record. The same plan, seed and version give the same record, byte for byte.
//!
//! Crates for what comes before and after a run:
//! * [`plan`]: plan files and the files that they name. [`faults`]: faults that a plan injects.
//! * [`record`]: everything that happened, how it ended, and the files of a run.
//! * [`judge`]: verdicts, each with the measurement's own uncertainty, and properties that must hold at every moment.
//! * [`campaign`]: cases, searches, the smallest case, envelopes.
//!
//! Crates from plan to record:
//! * `rig`: nodes on lines, the steps of a plan, and the loop in virtual time; no IO and no clock. It has
//!   [`operator`]: what a plan asks a person, and [`hosted`]: the controller under test.
//! * `live` (feature `live`): the real clock, ports, and a device under test in its own process.
//!
//! This crate:
//! * [`run`]: all of that in order; `run_live` on a bench. [`executors`]: the same for the cases of a campaign.
//!
//! Without a run folder, for many runs:
//!
//! ```
//! use harness::run::{Prepared, verdicts};
//! use harness::plan::made::Made;
//! use rig::operator::Answers;
//!
//! let prepared = Prepared::load("straight-accuracy", &Made::default())?;
//! let run = verdicts(&prepared, 1, &Answers::default(), &mut |_| true);
//! assert!(run.is_complete());
//! for measurement in &run.measurements {
//!     println!("{} {:?} {}", measurement.name, measurement.value, measurement.verdict.name());
//! }
//! # Ok::<(), harness::run::PrepareError>(())
//! ```

pub use crate::trial::{Trial, TrialCampaign, TrialError, TrialFindings, TrialRun};
pub use campaign;
/// The code under test, and the missions and reports that any controller in its place must handle.
pub use controller;
pub use judge;
pub use plan;
pub use plan::faults;
pub use record;
pub use rig::hosted::{self, HostedController};
pub use rig::operator;
/// Time, units, frames, and the bytes of gyros and bases.
pub use wire;

use judge::{checks, properties};
#[cfg(feature = "live")]
use plan::bench_file;
use plan::{calibrations, library, made, models, observation};
#[cfg(feature = "live")]
use ports as port;
use record::{outcome, run_folder};
use views::{console, watch};
#[cfg(feature = "report")]
use views::{junit, report};

pub mod executors;
pub mod program;
pub mod run;
#[cfg(feature = "live")]
pub mod run_live;
pub mod stopwatch;
pub mod trial;
