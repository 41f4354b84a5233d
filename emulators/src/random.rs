//! Random numbers, one stream for each purpose of each device.
//!
//! A stream is keyed by the run ([`seed_of_run`]: its seed and its plan), the device's name and the purpose. Draws
//! from one stream never affect another: an additional device on the bench, or a noise term switched on, changes no
//! other numbers.

use chacha20::ChaCha8Rng;
use rand::{Rng as _, SeedableRng as _};
use rand_distr::{Distribution as _, StandardNormal};

/// One stream of random numbers (ChaCha with 8 rounds: the same numbers on every platform).
#[derive(Debug)]
pub struct RandomStream {
    generator: ChaCha8Rng,
}

/// The copy draws the same numbers. The generator itself has no `Clone`, lest keys be reused by accident.
impl Clone for RandomStream {
    fn clone(&self) -> Self {
        Self { generator: ChaCha8Rng::deserialize_state(&self.generator.serialize_state()) }
    }
}

impl RandomStream {
    /// The stream of `device` for `purpose` in a run with `seed`.
    pub fn new(seed: u64, device: &str, purpose: &str) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8..16].copy_from_slice(&fnv1a(device).to_le_bytes());
        key[16..24].copy_from_slice(&fnv1a(purpose).to_le_bytes());
        Self { generator: ChaCha8Rng::from_seed(key) }
    }

    /// A draw from the normal distribution with mean 0 and variance 1 (ziggurat).
    #[inline]
    pub fn standard_normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.generator)
    }

    /// A draw from the uniform distribution over [-1, 1).
    pub fn symmetric_uniform(&mut self) -> f64 {
        /// 2^-52: the upper 53 bits of a draw, as a number in [0, 2).
        const STEP: f64 = 2.0 / (1u64 << 53) as f64;
        (self.generator.next_u64() >> 11) as f64 * STEP - 1.0
    }
}

/// The key of the streams of one run: its seed and the name of its plan. Two plans with the same seed share no noise.
pub fn seed_of_run(seed: u64, plan: &str) -> u64 {
    fnv1a(&format!("{plan} {seed}"))
}

/// FNV-1a, 64 bits (Fowler, Noll, Vo; constants of RFC 9923): short and stable, unlike the hashes of the standard
/// library.
fn fnv1a(text: &str) -> u64 {
    const OFFSET_BASIS: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0000_0100_0000_01b3;
    text.bytes().fold(OFFSET_BASIS, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(PRIME))
}

#[cfg(test)]
mod tests {
    use super::{RandomStream, fnv1a, seed_of_run};

    #[test]
    fn the_hash_is_the_published_one() {
        assert_eq!(fnv1a(""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fnv1a("a"), 0xaf63_dc4c_8601_ec8c);
        assert_eq!(fnv1a("foobar"), 0x8594_4171_f739_67e8);
    }

    #[test]
    fn plans_of_one_seed_share_no_noise() {
        let drawn = |seed, plan| {
            let mut stream = RandomStream::new(seed_of_run(seed, plan), "gyro", "white");
            [(); 1_000].map(|()| stream.standard_normal())
        };
        let (one, other) = (drawn(1, "temperature-calibration"), drawn(1, "verification"));
        let products = one.iter().zip(&other).map(|(a, b)| a * b);
        // The mean of 1,000 products of independent numbers has a standard deviation of 0.032.
        assert!((products.sum::<f64>() / 1_000.0).abs() < 0.13);
        assert_eq!(one, drawn(1, "temperature-calibration"));
        assert_ne!(one, drawn(2, "temperature-calibration"));
    }

    #[test]
    fn a_copy_draws_the_same_numbers() {
        let mut stream = RandomStream::new(1, "gyro", "white");
        // Odd counts stop within a block of the generator.
        for drawn in [0, 1, 7, 64] {
            (0..drawn).for_each(|_| _ = stream.standard_normal());
            let mut copy = stream.clone();
            let next = |stream: &mut RandomStream| [(); 100].map(|()| stream.standard_normal());
            assert_eq!(next(&mut copy), next(&mut stream));
        }
    }

    #[test]
    fn streams_differ_in_seed_device_and_purpose_and_repeat() {
        let first = |seed, device, purpose| {
            RandomStream::new(seed, device, purpose).standard_normal().to_bits()
        };
        let one = first(1, "gyro", "white");
        assert_eq!(one, first(1, "gyro", "white"));
        assert_ne!(one, first(2, "gyro", "white"));
        assert_ne!(one, first(1, "gyro2", "white"));
        assert_ne!(one, first(1, "gyro", "drift"));
    }

    /// Pins the numbers themselves: a library version with other numbers would change every record.
    #[test]
    fn the_numbers_are_the_same_everywhere() {
        let mut stream = RandomStream::new(7, "gyro", "white");
        let drawn = [(); 4].map(|()| stream.standard_normal().to_bits());
        assert_eq!(
            drawn,
            [
                0x3ff7_170f_6ca8_aa29,
                0x3ffc_eb8c_a67f_9a39,
                0xbfc2_d56d_dcf8_1cff,
                0x4001_3460_8c26_135c
            ]
        );
        assert_eq!(stream.symmetric_uniform().to_bits(), 0xbfdb_629d_f84d_38e4);
    }

    #[test]
    fn moments_are_those_of_the_distributions() {
        const DRAWS: u32 = 100_000;
        let mut stream = RandomStream::new(3, "a", "b");
        let (mut mean, mut square, mut largest) = (0.0, 0.0, 0.0f64);
        for _ in 0..DRAWS {
            let draw = stream.standard_normal();
            mean += draw / f64::from(DRAWS);
            square += draw * draw / f64::from(DRAWS);
            largest = largest.max(stream.symmetric_uniform().abs());
        }
        // Standard errors: 0.0032 of the mean, 0.0045 of the variance.
        assert!(mean.abs() < 0.013, "{mean}");
        assert!((square - 1.0).abs() < 0.018, "{square}");
        assert!(largest <= 1.0 && largest > 0.999);
    }
}
