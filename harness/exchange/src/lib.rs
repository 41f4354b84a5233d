//! Exports runs for other tools.
//!
//! * [`tables`]: a run as CSV and Parquet, for notebooks. [`mcap`]: for Foxglove. [`mf4`]: for measurement tools.
//! * [`moment`]: the state of a run at one instant, for fault finding.

mod facts;
pub mod mcap;
pub mod mf4;
pub mod moment;
pub mod tables;
mod wide;
