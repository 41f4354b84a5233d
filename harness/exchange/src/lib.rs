//! Runs for other tools, and what other tools recorded.
//!
//! * [`bus_log`]: logs of CAN buses and serial lines, in and out.
//! * [`tables`]: a run as CSV and Parquet, for notebooks. [`mcap`]: for Foxglove.

pub mod bus_log;
pub mod mcap;
pub mod tables;
