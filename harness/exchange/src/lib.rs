//! Exports runs for other tools.
//!
//! * [`tables`]: a run as CSV and Parquet, for notebooks. [`mcap`]: for Foxglove. [`mf4`]: for measurement tools.
//! * [`moment`]: the state of a run at one instant, for fault finding.

#![allow(
    missing_docs,
    reason = "a crate of this workspace; what others use is documented where `harness` exports it"
)]

mod exported;
pub mod mcap;
pub mod mf4;
pub mod moment;
pub mod tables;
mod wide;

pub use exported::{ExportError, Exported};
