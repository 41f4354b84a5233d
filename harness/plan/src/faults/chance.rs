//! Random numbers of a single fault.

use super::Fault;
use emulators::random::RandomStream;

/// The random numbers of one fault in one run: a stream for each of its random effects.
///
/// They depend on the seed of the run, the kind and the target of the fault, and on how many faults of that kind and
/// target stand before it. A fault keeps its numbers when others are added or taken out, and when its own time or size
/// changes: what a campaign makes smaller stays the case that it found.
#[derive(Debug, Clone)]
pub struct Chances {
    seed: u64,
    fault: String,
}

impl Chances {
    /// The numbers of `fault` in the run with `seed`, with `before` faults of its kind and target before it.
    pub fn new(seed: u64, fault: &Fault, before: usize) -> Self {
        Self { seed, fault: format!("{fault} {before}") }
    }

    /// The stream of this effect.
    pub fn of(&self, effect: &str) -> Chance {
        Chance::new(self.seed, &format!("{} {effect}", self.fault))
    }
}

/// Independent random numbers for an effect of a fault: its draws do not change those of other faults or of devices.
#[derive(Debug, Clone)]
pub struct Chance {
    stream: RandomStream,
}

impl Chance {
    /// The stream of this name in the run with `seed`.
    pub fn new(seed: u64, name: &str) -> Self {
        Self { stream: RandomStream::new(seed, "fault", name) }
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
