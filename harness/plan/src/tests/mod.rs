//! Whole plans: what they parse to, and how their mistakes are shown.

mod device;
mod errors;
mod faults;
mod paper;
