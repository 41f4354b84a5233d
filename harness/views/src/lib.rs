//! Views of a run, a campaign or an identification, for people and build servers. This crate decides nothing.
//!
//! * [`console`]: tables for a terminal.
//! * `report`, `junit` (feature `report`): one page with its figures, and a file for a build server.
//! * `drawing` (feature `report`): a rig as a picture.
//! * [`watch`](mod@watch): a model of a run in progress, without a terminal.

#![allow(
    missing_docs,
    reason = "a crate of this workspace; what others use is documented where `harness` exports it"
)]

pub mod console;
#[cfg(feature = "report")]
pub mod drawing;
#[cfg(feature = "report")]
pub mod junit;
#[cfg(feature = "report")]
pub mod report;
pub mod watch;
