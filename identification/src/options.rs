//! What a caller asks of an identification.

use crate::dataset::Dataset;

/// Options of an identification.
#[derive(Debug, Clone)]
pub struct Options {
    /// Seed of all random draws.
    pub seed: u64,
    /// Maximum number of causes to add to all quantities; a polynomial of one driver is one.
    pub max_effects: usize,
    /// A static set of the same device, from which the noise is taken.
    pub noise_from: Option<Dataset>,
}

impl Default for Options {
    fn default() -> Self {
        Self { seed: 1, max_effects: 6, noise_from: None }
    }
}
