//! Runs one campaign on many machines, through a NATS server with JetStream.
//!
//! ```text
//!  hil campaign --nats          server                              hil worker --nats  (any number)
//!  run() ── Remote ──── case ──► stream HIL_CASES   (work queue) ───► Worker ── Executor
//!             ▲                                                         │ extends its lease on the case
//!             └─ result ◄────── stream HIL_RESULTS (work queue) ◄───────┘ reports, then acknowledges
//!                               object store HIL    packages, failing cases, results of campaigns
//!                               bucket HIL_LEASES   who drives a bench, who carries on a campaign
//! ```
//!
//! * A case stays on the stream until its result is there, and the result stays until the coordinator's journal has it.
//!   So no worker, server or coordinator loses a case by its failure, and each case is counted once.
//! * [`Remote`] is an [`Executor`](campaign::Executor), so the campaign does not depend on machines. The cases and
//!   results are the same as in a single process.
//! * A [`Package`] contains everything that a worker needs from the coordinator's machine, named by its content.
//! * On a bench runs differ: the worker repeats cases by the rule in the package, first carries out the plan without
//!   faults, and in the end repeats the smallest case afresh. Each of these is a job on the same stream.
//! * Nothing depends on the arrival time of a message: a case considered lost is sent again under the same name.

#![allow(
    missing_docs,
    reason = "a crate of this workspace; what others use is documented where `harness` exports it"
)]

mod carry;
mod connect;
mod desk;
mod error;
mod job;
mod lease;
mod message;
mod package;
mod remote;
mod room;
mod take;
mod tray;
mod worker;

pub use carry::{Maker, Stopping};
pub use connect::{Credentials, News, Server};
pub use desk::StoredFile;
pub use error::NatsError;
pub use lease::Holder;
pub use message::Place;
pub use package::{NotHere, Package};
pub use remote::{Remote, RemoteSettings};
pub use worker::{WorkerSettings, work};

/// Version and commit of this build. Other builds do not carry out its cases.
pub const VERSION: &str = env!("HIL_BUILD");
