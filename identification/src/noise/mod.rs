//! Noise: white, random walk, and anything coloured as a sum of first-order Gauss-Markov processes.
//!
//! Flicker noise over some decades is such a sum with equal variances, a random walk is one with a long
//! correlation time, an offset that differs from run to run one with an endless correlation time.

mod fit;
mod whiten;

pub use fit::{Evidence, evidence, fit, retune};
pub use whiten::{Layout, Whitener};

/// One first-order Gauss-Markov process.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coloured {
    /// Correlation time, s; infinite for an offset of each run.
    pub correlation_s: f64,
    /// Its variance, in units of the white noise's.
    pub variance: f64,
}

/// A model of the noise. Variances are relative; the scale is estimated beside.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseModel {
    /// Variance of the white noise of an observation: 1, or 0 where there is none.
    pub white: f64,
    /// Variance that a unit of activity brings to a level.
    pub walk: f64,
    /// Coloured parts. On a level they are rates that add up.
    pub coloured: Vec<Coloured>,
    /// Standard deviation of each run's noise over that of all.
    pub run_scale: Vec<f64>,
}

impl NoiseModel {
    /// White noise, equal in all runs.
    pub fn white(runs: usize) -> Self {
        Self { white: 1.0, walk: 0.0, coloured: Vec::new(), run_scale: vec![1.0; runs] }
    }

    /// Is there anything but white noise?
    pub fn is_coloured(&self) -> bool {
        !self.coloured.is_empty()
    }
}
