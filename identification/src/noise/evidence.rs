//! How well a noise model explains a residual.

use super::{Layout, NoiseModel, Whitener};
use crate::linear::{Basis, Normal, dot};

/// How well a noise model explains a residual.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// Logarithm of the likelihood, with the scale at its best value.
    pub log_likelihood: f64,
    /// The best scale: standard deviation of a whitened observation.
    pub scale: f64,
    /// Observations that took part.
    pub used: usize,
}

/// Likelihood of `residual`, minus what `columns` explain, under `noise`.
pub fn evidence(
    layout: &Layout,
    residual: &[f64],
    columns: &[Vec<f64>],
    noise: &NoiseModel,
    left_out: &[bool],
) -> Evidence {
    let whitener = Whitener::new(layout, noise, left_out);
    let all: Vec<&[f64]> = columns.iter().map(Vec::as_slice).chain([residual]).collect();
    let mut white = whitener.apply_each(&all);
    let mut target = white.pop().unwrap_or_default();
    let (sum, width) =
        Normal::of(&white, &target).left(dot(&target, &target)).unwrap_or_else(|| {
            let mut basis = Basis::default();
            basis.extend(white);
            basis.project(&mut target);
            (dot(&target, &target), basis.len())
        });
    let used = whitener.used();
    let n = used as f64;
    let sum = sum.max(f64::MIN_POSITIVE);
    Evidence {
        log_likelihood: -0.5 * (n * (sum / n).ln() + whitener.log_determinant),
        scale: (sum / (n - width as f64).max(1.0)).sqrt(),
        used,
    }
}
