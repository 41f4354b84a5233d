//! A campaign in one process: cases drawn, carried out side by side, learnt from in their order, and kept.

use super::case::{Case, CaseResult, PANIC, Violated};
use super::executor::Executor;
use super::journal::{Journal, JournalError, Line};
use super::search::Search;
use super::shrink::{Shrunk, shrink};
use crate::outcome::Outcome;
use crate::seeds::for_each_seed;
use std::any::Any;
use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZeroUsize;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Cases that are drawn before what came of the first of them is learnt: always as many, so that the cases of a
/// campaign do not depend on how many threads carry them out.
pub const BATCH: usize = 16;

/// How a campaign goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Cases.
    pub cases: u64,
    /// Cases at a time.
    pub threads: NonZeroUsize,
    /// Tries to make one case smaller, at most.
    pub shrink_max: u64,
}

/// A property that broke.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// The property.
    pub property: String,
    /// Number of the first case that broke it, from 0.
    pub number: u64,
    /// That case.
    pub case: Case,
    /// The smallest case that breaks it.
    pub shrunk: Shrunk,
    /// How many cases broke it.
    pub times: u64,
}

/// What was counted.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Tally {
    /// Cases done.
    pub cases: u64,
    /// Of these, done before this campaign was resumed.
    pub resumed: u64,
    /// Runs that passed with every property held.
    pub passed: u64,
    /// How runs ended.
    pub outcomes: BTreeMap<String, u64>,
    /// How many cases broke each property, and the first of them.
    pub broken: BTreeMap<String, (u64, u64)>,
    /// How many cases came to each state.
    pub reached: BTreeMap<String, u64>,
    /// Where runs differ: how many cases broke a property once, and were not shown to break it again.
    pub unconfirmed: BTreeMap<String, u64>,
    /// Least margin of each property, and the case.
    pub nearest: BTreeMap<String, (f64, u64)>,
}

/// What a campaign came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Campaign {
    /// What was counted.
    pub tally: Tally,
    /// Properties that broke, in the order of their names.
    pub found: Vec<Found>,
    /// States that no case came to.
    pub never: Vec<String>,
    /// It was stopped before its end.
    pub stopped: bool,
}

/// Carries out a campaign. `states` are those that it should come to. `journal` holds what is done already: those
/// cases are learnt from and not carried out again. `pulse` is told of each case; false stops.
///
/// # Errors
///
/// When the journal cannot be kept.
pub fn run(
    executor: &impl Executor,
    search: &mut dyn Search,
    states: &BTreeSet<String>,
    settings: &Settings,
    journal: &mut Journal,
    pulse: &mut dyn FnMut(&Tally) -> bool,
) -> Result<Campaign, JournalError> {
    let mut tally = Tally::default();
    let mut first: BTreeMap<String, (u64, Case, CaseResult)> = BTreeMap::new();
    let mut stopped = false;
    let mut number = 0;
    while number < settings.cases && !stopped {
        let size = (settings.cases - number).min(BATCH as u64);
        let cases: Vec<Case> = (0..size).map(|_| search.next()).collect();
        let known = |offset: usize| {
            journal
                .done()
                .get(&(number + offset as u64))
                .filter(|line| line.case == cases[offset])
                .map(|line| line.result.clone())
        };
        let known: Vec<Option<CaseResult>> = (0..cases.len()).map(known).collect();
        let results = side_by_side(executor, &cases, &known, settings.threads);
        for ((case, result), known) in cases.iter().zip(results).zip(&known) {
            if result.outcome == Outcome::Aborted.name() {
                // Not carried out: the next time it is.
                stopped = true;
                break;
            }
            if known.is_none() {
                journal.keep(&Line { number, case: case.clone(), result: result.clone() })?;
            } else {
                tally.resumed += 1;
            }
            tally.count(number, &result);
            search.learn(case, &result);
            for violated in &result.violated {
                first
                    .entry(violated.property.clone())
                    .or_insert_with(|| (number, case.clone(), result.clone()));
            }
            number += 1;
        }
        stopped |= !pulse(&tally);
    }
    let found = first
        .into_iter()
        .map(|(property, (number, case, result))| {
            let shrunk = shrink(&Guarded(executor), &case, &result, &property, settings.shrink_max);
            let times = tally.broken.get(&property).map_or(0, |(times, _)| *times);
            Found { property, number, case, shrunk, times }
        })
        .collect();
    let never = states.iter().filter(|state| !tally.reached.contains_key(*state)).cloned();
    Ok(Campaign { never: never.collect(), tally, found, stopped })
}

impl Tally {
    fn count(&mut self, number: u64, result: &CaseResult) {
        self.cases += 1;
        self.passed += u64::from(result.passed && result.violated.is_empty());
        *self.outcomes.entry(result.outcome.clone()).or_default() += 1;
        for violated in &result.violated {
            self.broken.entry(violated.property.clone()).or_insert((0, number)).0 += 1;
        }
        for property in result.repeated.keys().filter(|property| !result.breaks(property)) {
            *self.unconfirmed.entry(property.clone()).or_default() += 1;
        }
        for state in &result.reached {
            *self.reached.entry(state.clone()).or_default() += 1;
        }
        for (property, margin) in &result.margins {
            let nearest = self.nearest.entry(property.clone()).or_insert((*margin, number));
            if *margin < nearest.0 {
                *nearest = (*margin, number);
            }
        }
    }
}

/// What came of each, in their order; what is known already is not carried out.
fn side_by_side(
    executor: &impl Executor,
    cases: &[Case],
    known: &[Option<CaseResult>],
    threads: NonZeroUsize,
) -> Vec<CaseResult> {
    let job = |index: u64| {
        let index = usize::try_from(index).ok()?;
        let (case, known) = (cases.get(index)?, known.get(index)?);
        Some(known.clone().unwrap_or_else(|| guarded(executor, case)))
    };
    let results = for_each_seed(0..cases.len() as u64, threads, &job);
    results.into_iter().map(|(_, result)| result).collect()
}

/// A controller that panics breaks a property; it does not end the campaign.
pub(super) fn guarded(executor: &impl Executor, case: &Case) -> CaseResult {
    match catch_unwind(AssertUnwindSafe(|| executor.execute(case))) {
        Ok(result) => result,
        Err(panic) => CaseResult {
            outcome: "panicked".to_owned(),
            violated: vec![Violated {
                property: PANIC.to_owned(),
                at_s: 0.0,
                what: message(panic.as_ref()),
            }],
            ..CaseResult::default()
        },
    }
}

fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "a panic without words".to_owned())
}

struct Guarded<'a, E>(&'a E);

impl<E: Executor> Executor for Guarded<'_, E> {
    fn execute(&self, case: &Case) -> CaseResult {
        guarded(self.0, case)
    }

    fn takes(&self, case: &Case) -> bool {
        self.0.takes(case)
    }
}

#[cfg(test)]
mod tests {
    use super::{Campaign, Settings, run};
    use crate::campaign::toy::{Toy, space};
    use crate::campaign::{Case, CaseResult, Executor, Guided, Journal, PANIC};
    use std::collections::BTreeSet;
    use std::num::NonZeroUsize;
    use std::path::Path;
    use std::sync::atomic::{AtomicU64, Ordering};

    fn settings(cases: u64, threads: usize) -> Settings {
        Settings { cases, threads: NonZeroUsize::new(threads).unwrap(), shrink_max: 300 }
    }

    fn campaign(executor: &impl Executor, settings: &Settings, folder: &Path) -> Campaign {
        let mut journal = Journal::open(&folder.join("journal.jsonl"), "toy").unwrap();
        let mut search = Guided::new(&space(), 4);
        let states: BTreeSet<String> =
            ["2-faults", "9-faults"].into_iter().map(str::to_owned).collect();
        run(executor, &mut search, &states, settings, &mut journal, &mut |_| true).unwrap()
    }

    #[test]
    fn what_breaks_is_found_counted_and_made_small() {
        let folder = tempfile::tempdir().unwrap();
        let done = campaign(&Toy::default(), &settings(400, 1), folder.path());
        assert_eq!(done.tally.cases, 400);
        let [found] = done.found.as_slice() else { panic!("{:?}", done.found) };
        assert_eq!(found.property, "held");
        assert_eq!(found.shrunk.case.schedule.faults.len(), 2);
        assert_eq!(done.tally.broken["held"], (found.times, found.number));
        assert_eq!(done.never, ["9-faults"]);
    }

    #[test]
    fn threads_change_nothing() {
        let one = campaign(&Toy::default(), &settings(100, 1), tempfile::tempdir().unwrap().path());
        let four =
            campaign(&Toy::default(), &settings(100, 4), tempfile::tempdir().unwrap().path());
        assert_eq!(one, four);
    }

    /// Counts what it carries out.
    struct Counted(AtomicU64);

    impl Executor for Counted {
        fn execute(&self, case: &Case) -> CaseResult {
            self.0.fetch_add(1, Ordering::Relaxed);
            let mut result = Toy::default().execute(case);
            // Nothing to make small.
            result.violated.clear();
            result
        }
    }

    #[test]
    fn one_that_was_interrupted_goes_on_where_it_stopped() {
        let folder = tempfile::tempdir().unwrap();
        let counted = Counted(AtomicU64::new(0));
        campaign(&counted, &settings(48, 2), folder.path());
        let resumed = campaign(&counted, &settings(100, 2), folder.path());
        assert_eq!(counted.0.load(Ordering::Relaxed), 100, "none is done twice");
        assert_eq!(resumed.tally.resumed, 48);
        let whole = campaign(&counted, &settings(100, 2), tempfile::tempdir().unwrap().path());
        assert_eq!(whole.tally.nearest, resumed.tally.nearest);
        assert_eq!(whole.tally.reached, resumed.tally.reached);
    }

    #[test]
    fn a_panic_is_a_property_that_broke() {
        struct Panics;
        impl Executor for Panics {
            fn execute(&self, case: &Case) -> CaseResult {
                assert!(case.schedule.faults.len() < 3, "three faults");
                CaseResult::default()
            }
        }
        let done = campaign(&Panics, &settings(40, 2), tempfile::tempdir().unwrap().path());
        let [found] = done.found.as_slice() else { panic!("{:?}", done.found) };
        assert_eq!(found.property, PANIC);
        assert_eq!(found.shrunk.case.schedule.faults.len(), 3);
        assert!(found.shrunk.result.violated[0].what.contains("three faults"));
    }
}
