//! Runs for other tools, and what other tools recorded.
//!
//! * [`tables`]: a run as CSV and Parquet, for notebooks. [`mcap`]: for Foxglove.

pub mod mcap;
pub mod tables;
