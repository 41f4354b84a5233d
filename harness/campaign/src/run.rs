//! A campaign: cases drawn, carried out side by side, learnt from in their order, and kept.

use super::case::{Case, CaseResult};
use super::executor::Executor;
use super::guard::{Guarded, guarded};
use super::journal::{Journal, JournalError};
use super::search::Search;
use super::shrink::{Shrunk, shrink};
use super::window::{Step, Window};
use crate::seeds::for_each_seed;
use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZeroUsize;

/// How a campaign goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Cases.
    pub cases: u64,
    /// Cases at a time: processors of this machine, or [`WINDOW`](super::WINDOW) where other machines carry them out.
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
/// cases are learnt from and not carried out again. `pulse` is told of each case that is learnt from, and is called now
/// and then while none is; false stops. A case that ends [`Aborted`](record::outcome::Outcome::Aborted) was given up: it is not kept, and the
/// campaign stops.
///
/// Case number k is drawn once the results of all cases up to k - [`WINDOW`](super::WINDOW) are learnt, in their order:
/// the cases are the same whoever carries them out, and however many at a time.
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
    let done = std::mem::take(&mut journal.done);
    let known = |number: u64, case: &Case| {
        done.get(&number).filter(|line| line.case == *case).map(|line| line.result.clone())
    };
    let job = |case: &Case| guarded(executor, case);
    let window = Window { cases: settings.cases, threads: settings.threads };
    let stopped = window.run(search, &known, &job, &mut |step| match step {
        Step::Done(line) if line.result.is_given_up() => Ok(false),
        Step::Done(line) => {
            journal.keep(line)?;
            executor.kept(&line.case);
            Ok(true)
        }
        Step::Learnt { line, resumed } => {
            tally.resumed += u64::from(resumed);
            tally.count(line.number, &line.result);
            for violated in &line.result.violated {
                first
                    .entry(violated.property.clone())
                    .or_insert_with(|| (line.number, line.case.clone(), line.result.clone()));
            }
            Ok(pulse(&tally))
        }
        Step::Waiting => Ok(pulse(&tally)),
    })?;
    journal.done = done;
    let found = made_small(executor, first, &tally, settings);
    let never = states.iter().filter(|state| !tally.reached.contains_key(*state)).cloned();
    Ok(Campaign { never: never.collect(), tally, found, stopped })
}

/// The smallest case of each property, several properties at a time.
fn made_small(
    executor: &impl Executor,
    first: BTreeMap<String, (u64, Case, CaseResult)>,
    tally: &Tally,
    settings: &Settings,
) -> Vec<Found> {
    let first: Vec<_> = first.into_iter().collect();
    let job = |index: u64| {
        let (property, (number, case, result)) = first.get(usize::try_from(index).ok()?)?;
        let shrunk = shrink(&Guarded(executor), case, result, property, settings.shrink_max);
        let times = tally.broken.get(property).map_or(0, |(times, _)| *times);
        let (property, number, case) = (property.clone(), *number, case.clone());
        Some(Found { property, number, case, shrunk, times })
    };
    let found = for_each_seed(0..first.len() as u64, settings.threads, &job);
    found.into_iter().map(|(_, found)| found).collect()
}

impl Tally {
    /// Counts one case more, whatever is known of it.
    pub fn count(&mut self, number: u64, result: &CaseResult) {
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

#[cfg(test)]
mod tests {
    use super::{Campaign, Settings, run};
    use crate::toy::{Toy, space};
    use crate::{Case, CaseResult, Executor, Guided, Journal, PANIC};
    use record::outcome::Outcome;
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

    /// Gives up after so many cases, as one does whose bench is interrupted.
    struct Tired(AtomicU64);

    impl Executor for Tired {
        fn execute(&self, case: &Case) -> CaseResult {
            let mut result = Toy::default().execute(case);
            if self.0.fetch_add(1, Ordering::Relaxed) >= 30 {
                result.outcome = Outcome::Aborted.name().to_owned();
            }
            result
        }
    }

    #[test]
    fn a_case_that_was_given_up_is_neither_kept_nor_learnt_from() {
        let folder = tempfile::tempdir().unwrap();
        let stopped = campaign(&Tired(AtomicU64::new(0)), &settings(100, 1), folder.path());
        assert!(stopped.stopped);
        assert_eq!(stopped.tally.cases, 30);
        let resumed = campaign(&Toy::default(), &settings(100, 1), folder.path());
        assert_eq!((resumed.tally.resumed, resumed.tally.cases), (30, 100));
        let whole =
            campaign(&Toy::default(), &settings(100, 1), tempfile::tempdir().unwrap().path());
        assert_eq!(whole.found, resumed.found);
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
