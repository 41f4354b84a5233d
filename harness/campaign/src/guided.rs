//! Looks everywhere evenly, and goes down along margins as far as that pays.

use super::case::{Case, CaseResult};
use super::mutation::mutated;
use super::search::{Dice, Search};
use super::space::Space;
use super::survey::Survey;
use rand::RngExt as _;
use std::collections::{BTreeMap, VecDeque};

/// Best cases that are kept for each property.
const KEPT: usize = 4;
/// Share of cases that are changes of earlier ones: at least, at most, and before it is known whether they pay.
const DESCENT: (f64, f64) = (0.05, 0.6);
/// See [`DESCENT`].
const DESCENT_FIRST: f64 = 0.15;
/// How much the last change says of whether changes pay.
const MEMORY: f64 = 0.1;
/// A margin has come down where it is less than the greatest that was seen by this share of it.
const DOWN: f64 = 0.05;

/// Goes down along the margins of the properties, as falsification of cyber-physical systems does (Annpureddy, Liu,
/// Fainekos and Sankaranarayanan, S-TaLiRo, 2011), from cases that cover the space evenly.
///
/// A margin says nothing of a mistake until a case is nearly there: then it leads on, and until then only other kinds,
/// phases and severities do. So the share of cases that are changes of those that came nearest to break a property
/// follows from how often such a change came nearer still (adaptive choice of operators; Fialho, 2010); all others are
/// drawn evenly. Several cases may be drawn before what came of the first of them is learnt.
#[derive(Debug)]
pub struct Guided {
    space: Space,
    dice: Dice,
    survey: Survey,
    /// The nearest cases of each property, the nearest first.
    nearest: BTreeMap<String, Vec<(f64, Case)>>,
    /// The greatest margin of each property: that of a run in which nothing comes near.
    farthest: BTreeMap<String, f64>,
    /// Properties that are found broken: nothing is left to be learnt of them.
    broken: Vec<String>,
    /// Of each case that is drawn and not learnt, the property along which it goes down.
    under_way: VecDeque<Option<String>>,
    /// How often going down along each property came nearer, of late.
    pays: BTreeMap<String, f64>,
    /// The same of all of them.
    descent: f64,
}

impl Guided {
    /// In `space`; `seed` says which.
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

    /// A property to go down along, more likely one that pays, and a change of one of its nearest cases.
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
        // The nearest is as likely as all others together.
        let rank = self.dice.random.random_range(0..2 * cases.len()).saturating_sub(cases.len());
        let parent = cases.get(rank)?.1.clone();
        let case = mutated(&parent, &self.space, &mut self.survey, &mut self.dice)?;
        Some((property, case))
    }

    /// Keeps a case where it is among the nearest of a property; true where it is nearer than all.
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

    /// Cases until the toy breaks, of which so many are drawn before the first is learnt.
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

    /// The toy breaks where two of its faults are large and close together: the margin leads there, and still does
    /// when many cases are drawn ahead.
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
