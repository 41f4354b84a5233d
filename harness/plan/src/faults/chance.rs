//! Random numbers of a single fault.

use emulators::random::RandomStream;

/// Independent random numbers for a fault: its draws do not change those of other faults or of devices.
#[derive(Debug, Clone)]
pub struct Chance {
    stream: RandomStream,
}

impl Chance {
    /// The numbers of the fault with this number in the run with `seed`; a fault with two random effects appends a word
    /// to its number.
    pub fn new(seed: u64, number: &str) -> Self {
        Self { stream: RandomStream::new(seed, "fault", number) }
    }

    /// Uniform over [0, 1).
    pub fn uniform(&mut self) -> f64 {
        (self.stream.symmetric_uniform() + 1.0) / 2.0
    }

    /// True with this probability.
    pub fn happens(&mut self, probability: f64) -> bool {
        self.uniform() < probability
    }

    /// One of `0..count`; 0 if `count` is 0.
    pub fn below(&mut self, count: usize) -> usize {
        ((self.uniform() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// The stream itself, for devices that draw from it.
    pub fn into_stream(self) -> RandomStream {
        self.stream
    }
}
