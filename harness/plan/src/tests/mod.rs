//! Whole plans: parsing, and the display of mistakes.

mod device;
mod errors;
mod faults;
mod paper;
