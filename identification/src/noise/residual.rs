//! What noise is fitted to, and how well it explains it.

use super::{Layout, NoiseModel, Whitener};
use crate::linear::Normal;

/// A residual, less what columns explain of it, as noise is fitted to it.
#[derive(Clone, Copy)]
pub struct Residual<'a> {
    pub layout: &'a Layout,
    /// One per observation.
    pub values: &'a [f64],
    pub columns: &'a [Vec<f64>],
}

impl Residual<'_> {
    /// Logarithm of the likelihood under `noise`, with its scale at its best value.
    pub fn log_likelihood(self, noise: &NoiseModel) -> f64 {
        let whitener = Whitener::new(self.layout, noise);
        let all: Vec<&[f64]> =
            self.columns.iter().map(Vec::as_slice).chain([self.values]).collect();
        let mut white = whitener.apply_all(&all);
        let target = white.pop().unwrap_or_default();
        let left = Normal::of(&white, &target).left_of(&target, || white);
        whitener.log_likelihood(left)
    }
}
