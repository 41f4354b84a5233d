//! Verdicts on a run.
//!
//! * [`checks`]: one figure per measurement, compared with its band, with the figure's own uncertainty.
//! * [`properties`]: conditions that must hold at every moment, judged during the run.

pub mod checks;
pub mod properties;
pub mod unseen;
