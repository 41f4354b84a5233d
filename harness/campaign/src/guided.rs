//! Covers the space evenly, and descends along margins as far as that pays off.

use super::case::{Case, CaseResult};
use super::mutation::mutated;
use super::search::{Dice, Search};
use super::space::Space;
use super::survey::Survey;
use rand::RngExt as _;
use std::collections::{BTreeMap, VecDeque};

/// Number of best cases kept per property.
const KEPT: usize = 4;
/// Share of cases that mutate earlier ones: minimum and maximum.
const DESCENT: (f64, f64) = (0.05, 0.6);
/// Initial share, until the success of mutations is known.
const DESCENT_FIRST: f64 = 0.15;
/// Weight of the last mutation in the estimate of success.
const MEMORY: f64 = 0.1;
/// A margin counts as decreased if it is below the greatest seen by this share.
const DOWN: f64 = 0.05;

/// Descends along the margins of the properties, as in the falsification of cyber-physical systems (Annpureddy, Liu,
/// Fainekos and Sankaranarayanan, S-TaLiRo, 2011), from cases that cover the space evenly.
///
/// A margin carries no information until a case is close to a violation; from there it guides the search, and until
/// then only other kinds, phases and severities help. So the share of mutations of the closest cases follows from how
/// often such a mutation came closer (adaptive choice of operators; Fialho, 2010); all other cases are drawn evenly.
/// Several cases may be drawn before the result of the first is learnt.
#[derive(Debug)]
pub struct Guided {
    space: Space,
    dice: Dice,
    survey: Survey,
    /// The closest cases of each property, the closest first.
    nearest: BTreeMap<String, Vec<(f64, Case)>>,
    /// The greatest margin of each property: that of an uneventful run.
    farthest: BTreeMap<String, f64>,
    /// Broken properties, which need no further search.
    broken: Vec<String>,
    /// For each case drawn but not learnt yet: the property of its descent, if any.
    under_way: VecDeque<Option<String>>,
    /// Recent success rate of the descent along each property.
    pays: BTreeMap<String, f64>,
    /// The same rate over all properties.
    descent: f64,
}

impl Guided {
    /// Searches `space` with random numbers from `seed`.
    pub fn new(space: &Space, seed: u64) -> Self {
        let mut dice = Dice::new(seed);
        Self {
            survey: Survey::new(space, &mut dice),
            space: space.clone(),
            dice,
            nearest: BTreeMap::new(),
            farthest: BTreeMap::new(),
            broken: Vec::new(),
            under_way: VecDeque::new(),
            pays: BTreeMap::new(),
            descent: DESCENT_FIRST,
        }
    }

    /// Mutates one of the closest cases of a property; properties with success are more likely.
    fn descend(&mut self) -> Option<(String, Case)> {
        let weights: Vec<(&String, f64)> = self
            .nearest
            .iter()
            .filter(|(property, cases)| {
                let far = self.farthest.get(*property).copied().unwrap_or_default();
                let came_down =
                    cases.first().is_some_and(|(margin, _)| *margin < far * (1.0 - DOWN));
                came_down && !self.broken.contains(property)
            })
            .map(|(property, _)| (property, self.pays.get(property).copied().unwrap_or(1.0)))
            .collect();
        let total: f64 = weights.iter().map(|(_, weight)| weight).sum();
        let mut left = total * self.dice.random.random::<f64>();
        let chosen = weights.iter().find(|(_, weight)| {
            left -= weight;
            left <= 0.0
        });
        let property = chosen.or(weights.last())?.0.clone();
        let cases = self.nearest.get(&property)?;
        // The closest is as likely as all others together.
        let rank = self.dice.random.random_range(0..2 * cases.len()).saturating_sub(cases.len());
        let parent = cases.get(rank)?.1.clone();
        let case = mutated(&parent, &self.space, &mut self.survey, &mut self.dice)?;
        Some((property, case))
    }

    /// Keeps a case if it is among the closest of a property; returns whether it is closer than all.
    fn keep(&mut self, property: &str, margin: f64, case: &Case) -> bool {
        let farthest = self.farthest.entry(property.to_owned()).or_insert(margin);
        *farthest = farthest.max(margin);
        let cases = self.nearest.entry(property.to_owned()).or_default();
        let is_nearer = cases.first().is_some_and(|(least, _)| margin < *least);
        let at = cases.partition_point(|(known, _)| *known < margin);
        cases.insert(at, (margin, case.clone()));
        cases.truncate(KEPT);
        is_nearer
    }
}

impl Search for Guided {
    fn next(&mut self) -> Case {
        let (least, most) = DESCENT;
        if self.dice.random.random_bool(self.descent.clamp(least, most))
            && let Some((property, case)) = self.descend()
        {
            self.under_way.push_back(Some(property));
            return case;
        }
        self.under_way.push_back(None);
        self.survey.case(&mut self.dice)
    }

    fn learn(&mut self, case: &Case, result: &CaseResult) {
        let along = self.under_way.pop_front().flatten();
        let mut stirred =
            !result.passed || !result.violated.is_empty() || !result.reached.is_empty();
        for (property, margin) in &result.margins {
            let is_nearer = self.keep(property, *margin, case);
            stirred |= self.farthest.get(property).is_some_and(|far| *margin < far * (1.0 - DOWN));
            if along.as_deref() == Some(property) {
                let paid = f64::from(u8::from(is_nearer));
                let pays = self.pays.entry(property.clone()).or_insert(1.0);
                *pays += MEMORY * (paid - *pays);
                self.descent += MEMORY * (paid - self.descent);
            }
        }
        self.survey.learn(case, stirred);
        for violated in &result.violated {
            if !self.broken.contains(&violated.property) {
                self.broken.push(violated.property.clone());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Guided;
    use crate::toy::{Toy, space};
    use crate::{Case, Executor as _, Random, Search};
    use std::collections::VecDeque;

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
    }

    #[test]
    fn every_case_can_apply() {
        let (space, toy) = (space(), Toy::default());
        for case in cases(&mut Guided::new(&space, 3), &toy, 300) {
            assert!(space.takes(&case.schedule), "{}", case.schedule.to_toml());
            assert!((1..=space.faults_max()).contains(&case.schedule.faults.len()));
        }
    }

    /// Number of cases until the toy breaks, when this many are drawn before the first is learnt.
    fn needed(search: &mut dyn Search, toy: &Toy, window: usize) -> usize {
        const CASES_MAX: usize = 3_000;
        let mut drawn: VecDeque<Case> = VecDeque::new();
        for number in 1..=CASES_MAX {
            while drawn.len() < window {
                drawn.push_back(search.next());
            }
            let Some(case) = drawn.pop_front() else { break };
            let result = toy.execute(&case);
            search.learn(&case, &result);
            if !result.violated.is_empty() {
                return number;
            }
        }
        CASES_MAX
    }

    /// The toy breaks if two of its faults are large and close together: the margin leads there, even when many cases
    /// are drawn ahead.
    #[test]
    fn margins_lead_to_what_chance_finds_late() {
        let (space, toy) = (space(), Toy::narrow());
        let random: usize =
            (0..10).map(|seed| needed(&mut Random::new(&space, seed), &toy, 1)).sum();
        for window in [1, 64] {
            let guided: usize =
                (0..10).map(|seed| needed(&mut Guided::new(&space, seed), &toy, window)).sum();
            assert!(2 * guided < random, "{window} ahead: {guided} cases, by chance {random}");
        }
    }
}
