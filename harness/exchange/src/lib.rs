//! Runs for other tools, and what other tools recorded.
//!
//! * [`tables`]: a run as CSV and Parquet, for notebooks. [`mcap`]: for Foxglove.
//! * [`moment`]: what stood in a run at one moment, for whoever asks what went wrong.

pub mod mcap;
pub mod moment;
pub mod tables;
