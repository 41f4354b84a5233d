//! Verdicts on what happened in a run.
//!
//! * [`checks`]: one figure a measurement, held against its band, with the figure's own uncertainty.
//! * [`properties`]: what must hold at every moment, judged as the run goes.

pub mod checks;
pub mod properties;
