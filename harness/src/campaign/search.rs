//! Which case is next.

use super::case::{Case, CaseResult};
use super::mutation::mutated;
use super::space::Space;
use chacha20::ChaCha8Rng;
use proptest::strategy::{BoxedStrategy, Strategy as _, ValueTree as _};
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use rand::{RngExt as _, SeedableRng as _};
use std::collections::BTreeMap;

use crate::faults::Schedule;

/// Draws cases, and may learn from what came of them.
pub trait Search {
    /// The next case.
    fn next(&mut self) -> Case;

    /// What came of one. Results come in the order in which the cases were drawn.
    fn learn(&mut self, case: &Case, result: &CaseResult);
}

/// Cases without regard to what came of earlier ones.
#[derive(Debug)]
pub struct Random {
    draws: Draws,
}

/// Where chance comes from: what strategies draw from, and all other decisions.
#[derive(Debug)]
pub(super) struct Dice {
    pub(super) runner: TestRunner,
    pub(super) random: ChaCha8Rng,
}

/// Seeds and schedules.
#[derive(Debug)]
struct Draws {
    schedule: BoxedStrategy<Schedule>,
    dice: Dice,
}

impl Draws {
    fn new(space: &Space, seed: u64) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        let random = TestRng::from_seed(RngAlgorithm::ChaCha, &key);
        let runner = TestRunner::new_with_rng(Config::default(), random);
        let dice = Dice { runner, random: ChaCha8Rng::from_seed(key) };
        Self { schedule: space.schedule(), dice }
    }

    fn case(&mut self) -> Case {
        let seed = self.dice.random.random();
        // What cannot apply is drawn again, a bounded number of times.
        let schedule = self.schedule.new_tree(&mut self.dice.runner).map(|tree| tree.current());
        Case { seed, schedule: schedule.unwrap_or_default() }
    }
}

impl Random {
    /// Of `space`; `seed` says which.
    pub fn new(space: &Space, seed: u64) -> Self {
        Self { draws: Draws::new(space, seed) }
    }
}

impl Search for Random {
    fn next(&mut self) -> Case {
        self.draws.case()
    }

    fn learn(&mut self, _: &Case, _: &CaseResult) {}
}

/// Cases drawn before anything is learnt from them.
const FIRST: usize = 20;
/// Share of cases that are drawn without regard to earlier ones ever after: what leads downhill may lead nowhere.
const FRESH: f64 = 0.25;
/// Best cases that are kept for each property.
const KEPT: usize = 4;

/// Goes down along the margins of the properties, as falsification of cyber-physical systems does (Annpureddy,
/// Liu, Fainekos and Sankaranarayanan, S-TaLiRo, 2011): for each property the cases that came nearest to break it are
/// kept, and changed a little. A state that no case reached before is worth keeping too.
#[derive(Debug)]
pub struct Guided {
    draws: Draws,
    space: Space,
    drawn: usize,
    /// The nearest cases of each property, the nearest first.
    nearest: BTreeMap<String, Vec<(f64, Case)>>,
    /// The first case that reached each state.
    reached: BTreeMap<String, Case>,
    /// Properties that are found broken: nothing is left to be learnt of them.
    broken: Vec<String>,
}

impl Guided {
    /// In `space`; `seed` says which.
    pub fn new(space: &Space, seed: u64) -> Self {
        Self {
            draws: Draws::new(space, seed),
            space: space.clone(),
            drawn: 0,
            nearest: BTreeMap::new(),
            reached: BTreeMap::new(),
            broken: Vec::new(),
        }
    }

    /// Something to change: of a property at random one of its nearest, or the first that reached a state.
    fn parent(&mut self) -> Option<Case> {
        let random = &mut self.draws.dice.random;
        let open: Vec<&Vec<(f64, Case)>> = self
            .nearest
            .iter()
            .filter(|(property, _)| !self.broken.contains(property))
            .map(|(_, cases)| cases)
            .collect();
        let choices = open.len() + usize::from(!self.reached.is_empty());
        if choices == 0 {
            return None;
        }
        let chosen = random.random_range(0..choices);
        if let Some(cases) = open.get(chosen) {
            return cases.get(random.random_range(0..cases.len())).map(|(_, case)| case.clone());
        }
        let which = random.random_range(0..self.reached.len());
        self.reached.values().nth(which).cloned()
    }
}

impl Search for Guided {
    fn next(&mut self) -> Case {
        self.drawn += 1;
        if self.drawn <= FIRST || self.draws.dice.random.random_bool(FRESH) {
            return self.draws.case();
        }
        let Some(parent) = self.parent() else { return self.draws.case() };
        let space = &self.space;
        mutated(&parent, space, &mut self.draws.dice).unwrap_or_else(|| self.draws.case())
    }

    fn learn(&mut self, case: &Case, result: &CaseResult) {
        for (property, margin) in &result.margins {
            let cases = self.nearest.entry(property.clone()).or_default();
            let at = cases.partition_point(|(known, _)| known <= margin);
            cases.insert(at, (*margin, case.clone()));
            cases.truncate(KEPT);
        }
        for state in &result.reached {
            self.reached.entry(state.clone()).or_insert_with(|| case.clone());
        }
        for violated in &result.violated {
            if !self.broken.contains(&violated.property) {
                self.broken.push(violated.property.clone());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Guided, Random, Search};
    use crate::campaign::toy::{Toy, space};
    use crate::campaign::{Case, Executor as _};

    fn cases(search: &mut dyn Search, toy: &Toy, count: usize) -> Vec<Case> {
        let draw = |_| {
            let case = search.next();
            search.learn(&case, &toy.execute(&case));
            case
        };
        (0..count).map(draw).collect()
    }

    #[test]
    fn a_seed_draws_the_same_cases_again_and_another_others() {
        let (space, toy) = (space(), Toy::default());
        let guided = |seed| cases(&mut Guided::new(&space, seed), &toy, 60);
        assert_eq!(guided(1), guided(1));
        assert_ne!(guided(1), guided(2));
        let random = |seed| cases(&mut Random::new(&space, seed), &toy, 60);
        assert_eq!(random(1), random(1));
    }

    #[test]
    fn every_case_can_apply() {
        let (space, toy) = (space(), Toy::default());
        for case in cases(&mut Guided::new(&space, 3), &toy, 300) {
            assert!(space.takes(&case.schedule), "{}", case.schedule.to_toml());
            assert!((1..=space.faults_max()).contains(&case.schedule.faults.len()));
        }
    }

    /// The toy breaks where two of its faults are large and close together: the margin leads there.
    #[test]
    fn margins_lead_to_what_chance_finds_late() {
        let (space, toy) = (space(), Toy::narrow());
        let needed = |search: &mut dyn Search| {
            (1..=3000).find(|_| {
                let case = search.next();
                let result = toy.execute(&case);
                search.learn(&case, &result);
                !result.violated.is_empty()
            })
        };
        let mut guided = 0;
        let mut random = 0;
        for seed in 0..10 {
            guided += needed(&mut Guided::new(&space, seed)).unwrap_or(3000);
            random += needed(&mut Random::new(&space, seed)).unwrap_or(3000);
        }
        assert!(2 * guided < random, "guided {guided}, random {random}");
    }
}
