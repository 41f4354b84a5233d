//! Runs for other tools, and what other tools recorded.
//!
//! * [`tables`]: a run as CSV and Parquet, for notebooks. [`mcap`]: for Foxglove. [`mf4`]: for tools of measuring.
//! * [`moment`]: what stood in a run at one moment, for whoever asks what went wrong.

mod facts;
pub mod mcap;
pub mod mf4;
pub mod moment;
pub mod tables;
mod wide;
