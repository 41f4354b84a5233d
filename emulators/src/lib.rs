//! x
pub mod gyro;
pub mod parameters;
pub mod random;
