//! Executors of campaign cases: [`Simulated`] in virtual time, `OnBench` in real time.

mod beginnings;
mod clocked;
#[cfg(feature = "live")]
mod on_bench;
mod passes;
mod simulated;

#[cfg(feature = "live")]
pub use on_bench::{Bench, OnBench, Site};
pub use simulated::Simulated;
