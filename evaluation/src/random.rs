//! Random numbers: every stream is keyed by its purpose, so that cases are independent of each other.

use chacha20::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal, StudentT};
use std::sync::atomic::{AtomicU64, Ordering};

/// The frozen master seed of the data that are identified. Never tuned.
pub const MASTER_TRAIN: u64 = 0x5EED_0F1D_E47E_0001;
/// The frozen master seed of the fresh data on which predictions are scored. Never tuned.
pub const MASTER_TEST: u64 = 0x5EED_0F1D_E47E_0002;

/// Value mixed into both master seeds: 0 for the evaluation itself, anything else for cases that may be inspected
/// during work on the identification.
static SHIFT: AtomicU64 = AtomicU64::new(0);

/// Replaces the frozen seeds.
pub fn shift_seeds(shift: u64) {
    SHIFT.store(shift, Ordering::Relaxed);
}

/// Offset basis and prime of the 64-bit FNV-1a hash.
const FNV_BASIS: u64 = 0xCBF2_9CE4_8422_2325;
const FNV_PRIME: u64 = 0x0000_0100_0000_01B3;

/// A stream of random numbers (ChaCha with 8 rounds: the same on every platform).
pub struct Stream(ChaCha8Rng);

impl Stream {
    /// The stream of that master seed, case and purpose.
    pub fn new(master: u64, case: &str, index: u64, purpose: &str) -> Self {
        let master = master ^ SHIFT.load(Ordering::Relaxed).rotate_left(17);
        let mut key = [0_u8; 32];
        for (lane, word) in key.chunks_exact_mut(8).enumerate() {
            let mut hash = FNV_BASIS ^ (lane as u64).wrapping_mul(FNV_PRIME);
            let bytes = [&master.to_le_bytes()[..], &index.to_le_bytes()[..]].concat();
            let text = case.bytes().chain([0]).chain(purpose.bytes());
            for byte in bytes.into_iter().chain(text) {
                hash = (hash ^ u64::from(byte)).wrapping_mul(FNV_PRIME);
            }
            word.copy_from_slice(&hash.to_le_bytes());
        }
        Self(ChaCha8Rng::from_seed(key))
    }

    /// Uniform in `[low, high)`.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    /// Uniform among `0..n`; `n` must not be 0.
    pub fn below(&mut self, n: usize) -> usize {
        self.0.random_range(0..n)
    }

    /// One of `choices`, which must not be empty.
    pub fn pick(&mut self, choices: &[f64]) -> f64 {
        choices[self.below(choices.len())]
    }

    /// +1 or -1.
    pub fn sign(&mut self) -> f64 {
        if self.0.random::<bool>() { 1.0 } else { -1.0 }
    }

    /// True with that probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.0.random::<f64>() < probability
    }

    /// Standard normal.
    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// Student's t with 3 degrees of freedom, scaled to variance 1.
    pub fn student_3(&mut self) -> f64 {
        let t: f64 = StudentT::new(3.0).map_or(0.0, |t| t.sample(&mut self.0));
        t / 3.0_f64.sqrt()
    }

    /// An Ornstein-Uhlenbeck path of `n` samples `dt` apart: standard deviation `sd`, correlation
    /// time `tau`, started in its stationary distribution.
    pub fn wander(&mut self, n: usize, dt: f64, sd: f64, tau: f64) -> Vec<f64> {
        let phi = (-dt / tau).exp();
        let innovation = sd * (1.0 - phi * phi).sqrt();
        let mut x = sd * self.normal();
        (0..n)
            .map(|_| {
                let now = x;
                x = phi * x + innovation * self.normal();
                now
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_of_other_keys_differ_and_of_the_same_key_agree() {
        let draw = |master, case: &str, index, purpose: &str| {
            Stream::new(master, case, index, purpose).between(0.0, 1.0)
        };
        let one = draw(1, "a", 0, "p");
        assert_eq!(one, draw(1, "a", 0, "p"));
        for other in
            [draw(2, "a", 0, "p"), draw(1, "b", 0, "p"), draw(1, "a", 1, "p"), draw(1, "a", 0, "q")]
        {
            assert_ne!(one, other);
        }
    }

    #[test]
    fn a_wander_has_the_deviation_it_was_asked_for() {
        let path = Stream::new(1, "wander", 0, "test").wander(200_000, 1.0, 2.0, 10.0);
        let mean_square = path.iter().map(|x| x * x).sum::<f64>() / path.len() as f64;
        assert!((mean_square.sqrt() - 2.0).abs() < 0.1, "{mean_square}");
    }
}
