//! x
pub mod base;
pub mod gyro;
pub mod parameters;
pub mod random;
