//! What we believe: models of a gyro and of a drive, and how measured data change them.
//!
//! Nothing here reads a file or a clock, and nothing knows what made the data.

pub mod dataset;
pub mod experiment;
pub mod finding;
pub mod identify;
pub mod model;
mod candidates;
mod lattice;
mod linear;
mod noise;
mod problem;
mod robust;
pub mod outcome;
mod select;
mod signal;
mod significance;
pub mod units;
