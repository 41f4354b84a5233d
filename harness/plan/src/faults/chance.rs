//! The random numbers of one fault.

use emulators::random::RandomStream;

/// Random numbers of a fault, its own: whatever one fault draws, others and all devices draw the same as
/// without it.
#[derive(Debug, Clone)]
pub struct Chance {
    stream: RandomStream,
}

impl Chance {
    /// Those of the fault of this number in the run with `seed`; what is faulty in two ways adds a word to its
    /// number.
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

    /// One of `0..count`; 0 where there is none.
    pub fn below(&mut self, count: usize) -> usize {
        ((self.uniform() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// The stream itself, for a device that draws from it.
    pub fn into_stream(self) -> RandomStream {
        self.stream
    }
}
