//! A rig: nodes connected by lines.
//!
//! ```text
//!   Director (the plan)            Observer (record, properties)
//!        │ orders                        ▲ what crosses
//!        ▼                               │
//!   node ──┤ line ├── node    node ──┤ line ├── node
//!    emulated, under test, tester, away: each a state machine; lines are paced, and faulty where a fault says so
//! ```
//!
//! [`simulate`] is the loop in virtual time; the crate `live` has the loop in real time. Both run the same nodes and
//! lines.
//!
//! * [`engine`]: the steps of a plan, without IO and without a clock. [`operator`]: what a plan asks a person.
//! * [`link`]: what is between the ends of a line. [`crossing`]: virtual time with every packet and frame sent through
//!   the kernel on its way.
//! * [`mod@bench`]: the emulated devices of the paper's robot or table, from a device file.
//! * [`hosted`]: the controller under test, and Rust code that plays a node.
//!
//! Order at equal times: begin and end faults, deliver what has arrived, wake what is due (emulated devices first, then
//! the devices under test, then the plan), transmit until nothing moves any more, record.

#![allow(
    missing_docs,
    reason = "a crate of this workspace; what others use is documented where `harness` exports it"
)]

pub mod bench;
pub mod build;
#[cfg(any(test, feature = "by-hand"))]
pub mod by_hand;
mod conversation;
pub mod crossing;
mod deliver;
pub mod director;
pub mod ended;
pub mod engine;
mod error_frame;
pub mod faults;
mod host;
pub mod hosted;
mod injector;
pub mod line;
pub mod link;
mod misplaced;
pub mod node;
mod oddities;
pub mod operator;
mod own;
mod remarks;
mod replayed;
pub mod rerun;
mod rig;
pub mod robot;
pub mod simulate;
mod slips;
mod supply;
pub mod talk;
pub mod tester;
mod touched;
mod unexpected;
pub mod watch;

pub use rig::Rig;

use record::Progress;
use record::sink::RecordSink;

/// Takes the record of a run.
pub type Sink<'a> = &'a mut dyn RecordSink;
/// Receives what the engine asks to keep.
pub type Keep<'a> = &'a mut dyn FnMut(&engine::Action);
/// Called between events now and then; if it returns `false`, the run is aborted.
pub type Pulse<'a> = &'a mut dyn FnMut(Progress) -> bool;
