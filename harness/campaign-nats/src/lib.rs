//! One campaign on many machines, through a NATS server with JetStream.
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
//! * A case is on the stream until what came of it is; what came of it is there until the coordinator's journal has it.
//!   So neither a worker nor the server nor the coordinator loses one by going away, and each is counted once.
//! * [`Remote`] is an [`Executor`](campaign::Executor): the campaign knows nothing of machines. The cases are those that
//!   one process would have drawn, and so is what comes of them.
//! * A [`Package`] is all that a worker needs of the coordinator's machine, by content.
//! * On a bench runs differ: the worker repeats by the rule in the package, carries the plan out without faults first, and
//!   repeats the smallest case afresh in the end. Each of these is a job on the same stream.
//! * Nothing here depends on when a message arrives: what was given up for lost is sent again under the same name.

mod carry;
mod connect;
mod desk;
mod error;
mod job;
mod lease;
mod maker;
mod message;
mod package;
mod publish;
mod remote;
mod results;
mod room;
mod take;
mod tray;
mod worker;

pub use connect::{Credentials, News, Server};
pub use desk::StoredFile;
pub use error::NatsError;
pub use lease::Holder;
pub use maker::{Maker, Stopping};
pub use message::Place;
pub use package::{NotHere, Package};
pub use remote::{Remote, RemoteSettings};
pub use worker::{Worked, WorkerSettings, work};

/// Which build this is: its version and commit. Cases of one are carried out by no other.
pub const VERSION: &str = env!("HIL_BUILD");
