//! The searches that choose the next case.

use super::case::{Case, CaseResult};
use super::space::Space;
use chacha20::ChaCha8Rng;
use plan::faults::Schedule;
use proptest::strategy::{BoxedStrategy, Strategy as _, ValueTree as _};
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use rand::{RngExt as _, SeedableRng as _};

/// Draws cases, and may learn from their results.
pub trait Search {
    /// The next case.
    fn next(&mut self) -> Case;

    /// Learns a result. Results come in the order in which the cases were drawn.
    fn learn(&mut self, case: &Case, result: &CaseResult);
}

/// Draws cases regardless of earlier results.
#[derive(Debug)]
pub struct Random {
    schedule: BoxedStrategy<Schedule>,
    dice: Dice,
}

/// Seeds that the cases of a campaign share. Cases with one seed are the same up to their first fault, which an executor
/// may run once for all of them.
const SEEDS: u64 = 32;

/// Random source for strategies and for all other decisions.
#[derive(Debug)]
pub(super) struct Dice {
    pub(super) runner: TestRunner,
    pub(super) random: ChaCha8Rng,
    /// The first of the [`SEEDS`].
    first_seed: u64,
}

impl Dice {
    pub(super) fn new(seed: u64) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        let random = TestRng::from_seed(RngAlgorithm::ChaCha, &key);
        let runner = TestRunner::new_with_rng(Config::default(), random);
        // Another stream: of this one, the searches draw.
        let mut seeds = ChaCha8Rng::from_seed(key);
        seeds.set_stream(1);
        Self { runner, random: ChaCha8Rng::from_seed(key), first_seed: seeds.random() }
    }

    /// The seed of a case.
    pub(super) fn seed(&mut self) -> u64 {
        self.first_seed.wrapping_add(self.random.random::<u64>() % SEEDS)
    }
}

impl Random {
    /// Searches `space` with random numbers from `seed`.
    pub fn new(space: &Space, seed: u64) -> Self {
        Self { schedule: space.schedule(), dice: Dice::new(seed) }
    }
}

impl Search for Random {
    fn next(&mut self) -> Case {
        let seed = self.dice.seed();
        // An inapplicable schedule is drawn again, a limited number of times.
        let schedule = self.schedule.new_tree(&mut self.dice.runner).map(|tree| tree.current());
        Case { seed, schedule: schedule.unwrap_or_default() }
    }

    fn learn(&mut self, _: &Case, _: &CaseResult) {}
}

#[cfg(test)]
mod tests {
    use super::{Random, Search as _};
    use crate::toy::space;

    #[test]
    fn a_seed_draws_the_same_cases_again_and_another_others() {
        let space = space();
        let cases = |seed| {
            let mut search = Random::new(&space, seed);
            (0..60).map(move |_| search.next()).collect::<Vec<_>>()
        };
        assert_eq!(cases(1), cases(1));
        assert_ne!(cases(1), cases(2));
    }
}
