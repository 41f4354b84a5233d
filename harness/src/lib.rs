//! Runs test plans on a bench of CAN and serial devices, simulated or real, and judges them.
//!
//! # In a test of one's own
//!
//! [`Trial`] is all that a `cargo test` needs: a plan, in virtual time, with emulated devices and, where one is brought, a
//! [controller of one's own](HostedController). Virtual time needs no feature:
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
//! [`trial`] has the whole; `examples/rust-tests` is a crate with a controller of its own and its tests.
//!
//! # How it is made
//!
//! ```text
//!  plan.toml ──> plan ──> engine ──> world ──> record ──> checks ──> summary, report, JUnit
//!  device file ─────────────────────┘  └ controller, gyro, base, table, absolute measurement
//! ```
//!
//! A plan says what is done and what is judged. The engine carries it out: missions to the controller
//! (the device under test), commands to the table, questions to the absolute measurement. A world
//! joins engine, controller and devices; in the simulated one time jumps from event to event and the
//! bytes are those of real lines. What happens is recorded, and the record is all that checks and
//! reports read. The same plan, seed and version give the same record, byte for byte.
//!
//! From file to verdict:
//! * [`plan`]: what a plan file may say. [`library`]: plans, device files and calibrations that ship.
//! * [`calibrations`], [`models`], [`made`]: what one plan makes and a later one uses.
//! * [`engine`]: the steps of a plan, without IO and without a clock.
//! * [`world`]: where plan, controller and devices meet. [`link`]: the lines between them.
//! * [`operator`]: what a plan asks a person. [`faults`]: what goes wrong on purpose.
//! * [`observation`], [`record`]: what was measured, and everything that happened.
//! * [`bus_log`]: logs of CAN buses and serial lines, in the formats of other tools.
//! * [`dataset`]: measured data, for the identification. [`export`]: runs as such data.
//! * [`tables`], [`mcap`]: runs for notebooks and for Foxglove.
//! * [`import`]: the log of a bench's CAN bus as a run.
//! * [`properties`]: what must hold at every moment of a run, judged as it goes.
//! * [`checks`]: verdicts, each with the measurement's own uncertainty. [`outcome`]: what they come to.
//! * [`run`]: all of that in order. [`seeds`]: the same for many seeds on all cores. [`hosted`]: whose controller is tested.
//! * [`bench_file`]: which port plays which role, and which device is tested.
//! * `live`, `run_live` (feature `live`): the real clock, and a device under test that is a process of its
//!   own. `port`: ptys, serial ports, CAN interfaces and adapters in one shape. `doctor`: what a machine
//!   and a bench lack. `emulation`: emulated devices on ports, for anybody's controller.
//!   `replay`: a recorded bus onto a port.
//!
//! For people and for machines:
//! * [`run_folder`]: what a run leaves behind. [`report`]: one page. [`junit`]: for a build server.
//! * [`schema`]: what editors complete and check plans and other files by.
//! * [`watch`](mod@watch): what is shown of a run while it goes on.
//! * [`reading`]: long files that say how much of them was read.
//! * [`console`]: tables. [`figures`]: how numbers are written. [`cli`]: the command `hil`.
//!
//! Without a folder, for whoever makes many runs:
//!
//! ```
//! use harness::run::{Prepared, verdicts};
//! use harness::made::Made;
//! use harness::operator::Answers;
//!
//! let prepared = Prepared::load("straight-accuracy", &Made::default())?;
//! let run = verdicts(&prepared, 1, &Answers::default(), &mut |_| true);
//! assert!(run.is_complete());
//! for measurement in &run.measurements {
//!     println!("{} {:?} {}", measurement.name, measurement.value, measurement.verdict.name());
//! }
//! # Ok::<(), harness::run::PrepareError>(())
//! ```

pub use crate::hosted::HostedController;
pub use crate::trial::{Trial, TrialCampaign, TrialError, TrialFindings, TrialRun};
/// The code under test, and the missions and reports that any controller in its place speaks.
pub use controller;
/// Time, units, frames, and the bytes of gyros and bases.
pub use wire;

pub use campaign::{self, seeds};
pub use dataset::{self, export};
pub use exchange::{bus_log, mcap, tables};
pub use judge::{checks, properties};
pub use plan;
pub use plan::{bench_file, calibrations, faults, library, made, models, observation};
#[cfg(feature = "live")]
pub use ports as port;
pub use record::{self, figures, outcome, reading, run_folder};
#[cfg(feature = "report")]
pub use views::report;
pub use views::{console, junit, watch};

pub mod cli;
#[cfg(feature = "live")]
pub mod doctor;
#[cfg(feature = "live")]
pub mod emulation;
pub mod engine;
pub mod executors;
pub mod hosted;
pub mod import;
pub mod link;
#[cfg(feature = "live")]
pub mod live;
#[cfg(feature = "nats")]
pub mod nats;
pub mod operator;
pub mod project;
#[cfg(feature = "live")]
pub mod replay;
pub mod run;
#[cfg(feature = "live")]
pub mod run_live;
pub mod schema;
mod stopwatch;
pub mod trial;
pub mod world;
