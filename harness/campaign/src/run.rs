//! Runs a campaign: draws cases, carries them out in parallel, learns from them in order, and stores them.

use super::case::{Case, CaseResult};
use super::executor::Executor;
use super::guard::{Guarded, guarded};
use super::journal::{Journal, JournalError};
use super::search::Search;
use super::shrink::{Shrunk, shrink};
use super::window::{Step, Window};
use crate::seeds::for_each_seed;
use record::outcome::Outcome;
use std::collections::BTreeMap;
use std::num::NonZeroUsize;

/// Settings of a campaign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Number of cases.
    pub cases: u64,
    /// Number of parallel cases: processors of this machine, or [`WINDOW`](super::WINDOW) if other machines carry them
    /// out.
    pub threads: NonZeroUsize,
    /// The most tries to shrink one case.
    pub shrink_max: u64,
}

/// A broken property.
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
    /// Number of cases that broke it.
    pub times: u64,
}

/// Counts over the cases.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Tally {
    /// Number of finished cases.
    pub cases: u64,
    /// Of these, the number finished before this campaign was resumed.
    pub resumed: u64,
    /// Number of cases that passed, with every measurement in its band and every property held.
    pub passed: u64,
    /// Number of cases per outcome ([`CaseResult::counts_as`]).
    pub outcomes: BTreeMap<String, u64>,
    /// For each outcome, the first case that broke no property: its number, and why it ended so.
    pub reasons: BTreeMap<String, (u64, String)>,
    /// Number of cases that broke each property, and the first of them.
    pub broken: BTreeMap<String, (u64, u64)>,
    /// Number of cases that reached each state.
    pub reached: BTreeMap<String, u64>,
    /// If runs differ: the number of cases that broke a property once without confirmation.
    pub unconfirmed: BTreeMap<String, u64>,
    /// Smallest margin of each property, and its case.
    pub nearest: BTreeMap<String, (f64, u64)>,
    /// Number of cases that put each always-property to the test: that had something to judge, and asked for something.
    pub tested: BTreeMap<String, u64>,
    /// Number of cases in which each always-property had nothing to judge, and why in the first of them.
    pub unjudged: BTreeMap<String, (u64, String)>,
}

/// Result of a campaign.
#[derive(Debug, Clone, PartialEq)]
pub struct Campaign {
    /// Counts over the cases.
    pub tally: Tally,
    /// Broken properties, sorted by name.
    pub found: Vec<Found>,
    /// States that no case reached.
    pub never: Vec<String>,
    /// Those of them that the plan demands.
    pub missed: Vec<String>,
    /// Whether it was stopped before its end.
    pub stopped: bool,
}

/// Runs a campaign. `states` are those that it should reach, and whether the plan demands it. `journal` contains finished cases, which are learnt from
/// and not carried out again. `pulse` is called for each case that is learnt from, and regularly in between; returning
/// false stops. A case that ends as [`Aborted`](record::outcome::Outcome::Aborted) was interrupted: it is not stored,
/// and the campaign stops.
///
/// Case number k is drawn once the results of all cases up to k - [`WINDOW`](super::WINDOW) have been learnt, in order.
/// So the cases depend neither on the executor nor on the number of parallel cases.
///
/// # Errors
///
/// When the journal cannot be written.
pub fn run(
    executor: &impl Executor,
    search: &mut dyn Search,
    states: &BTreeMap<String, bool>,
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
    let stopped = stopped || executor.is_stopped();
    let never = || states.iter().filter(|(state, _)| !tally.reached.contains_key(*state));
    let missed = never().filter(|(_, is_demanded)| **is_demanded);
    let missed = missed.map(|(state, _)| state.clone()).collect();
    let never = never().map(|(state, _)| state.clone()).collect();
    Ok(Campaign { never, missed, tally, found, stopped })
}

/// Shrinks the first case of each property, several properties in parallel.
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
    /// Always-properties that no case put to the test.
    pub fn untested(&self) -> impl Iterator<Item = &str> {
        let untested = self.tested.iter().filter(|(_, times)| **times == 0);
        untested.map(|(property, _)| property.as_str())
    }

    /// Number of cases that could have broken the property: in the others it had nothing to judge.
    pub fn judged(&self, property: &str) -> u64 {
        self.cases - self.unjudged.get(property).map_or(0, |(times, _)| *times)
    }

    /// Counts one more case, with whatever is known of it.
    pub fn count(&mut self, number: u64, result: &CaseResult) {
        self.cases += 1;
        let counts_as = result.counts_as();
        self.passed += u64::from(counts_as == Outcome::Passed.name());
        *self.outcomes.entry(counts_as.to_owned()).or_default() += 1;
        if let Some(reason) = result.reason.as_ref().filter(|_| result.violated.is_empty()) {
            let first = || (number, reason.clone());
            self.reasons.entry(counts_as.to_owned()).or_insert_with(first);
        }
        for violated in &result.violated {
            self.broken.entry(violated.property.clone()).or_insert((0, number)).0 += 1;
        }
        for property in result.repeated.keys().filter(|property| !result.breaks(property)) {
            *self.unconfirmed.entry(property.clone()).or_default() += 1;
        }
        for state in &result.reached {
            *self.reached.entry(state.clone()).or_default() += 1;
        }
        for (property, why) in &result.never_judged {
            self.unjudged.entry(property.clone()).or_insert_with(|| (0, why.clone())).0 += 1;
        }
        for property in result.never_judged.keys().chain(&result.never_asked) {
            self.tested.entry(property.clone()).or_default();
        }
        for (property, margin) in &result.margins {
            let is_tested = !result.never_asked.contains(property);
            *self.tested.entry(property.clone()).or_default() += u64::from(is_tested);
            let nearest = self.nearest.entry(property.clone()).or_insert((*margin, number));
            // Of some formulas the margin of a violation is zero, as that of cases that held: then it is the first of them.
            let is_first = self.broken.get(property).is_some_and(|(_, first)| *first == number);
            if *margin < nearest.0 || is_first && *margin <= nearest.0 {
                *nearest = (*margin, number);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Campaign, Settings, Tally, run};
    use crate::toy::{Toy, space};
    use crate::{Case, CaseResult, Executor, Guided, Journal, PANIC, Violated};
    use record::outcome::Outcome;
    use std::num::NonZeroUsize;
    use std::path::Path;
    use std::sync::atomic::{AtomicU64, Ordering};

    fn settings(cases: u64, threads: usize) -> Settings {
        Settings { cases, threads: NonZeroUsize::new(threads).unwrap(), shrink_max: 300 }
    }

    fn campaign(executor: &impl Executor, settings: &Settings, folder: &Path) -> Campaign {
        let mut journal = Journal::open(&folder.join("journal.jsonl"), "toy").unwrap();
        let mut search = Guided::new(&space(), 4);
        let states = [("2-faults", true), ("8-faults", false), ("9-faults", true)];
        let states = states.map(|(state, is_demanded)| (state.to_owned(), is_demanded)).into();
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
        assert_eq!(done.never, ["8-faults", "9-faults"]);
        assert_eq!(done.missed, ["9-faults"]);
    }

    #[test]
    fn a_case_counts_as_passed_only_if_every_property_was_judged_and_held() {
        let mut tally = Tally::default();
        let of = |outcome: &str, never: Option<&str>, property: Option<&str>| CaseResult {
            never_judged: never
                .map(|never| (never.to_owned(), String::new()))
                .into_iter()
                .collect(),
            violated: property.into_iter().map(broken).collect(),
            reason: (outcome == "error" || property.is_some()).then(|| "no answer".to_owned()),
            ..CaseResult::ended(outcome)
        };
        let results = [
            of("passed", None, None),
            of("passed", None, Some("held")),
            of("passed", Some("held"), None),
            of("failed", None, None),
            of("error", None, None),
        ];
        for (number, result) in (0..).zip(&results) {
            tally.count(number, result);
        }
        // A case that broke a property tells it by that.
        assert_eq!(tally.reasons, [("error".to_owned(), (4, "no answer".to_owned()))].into());
        let outcomes = [("error", 1), ("failed", 3), ("passed", 1)];
        assert_eq!(tally.outcomes, outcomes.map(|(name, times)| (name.to_owned(), times)).into());
        assert_eq!(tally.passed, 1);
        assert_eq!((tally.judged("held"), tally.judged("other")), (4, 5));
    }

    /// Found by a user: the case with the least margin, zero, was the first, which held.
    #[test]
    fn the_nearest_case_is_one_that_broke() {
        let mut tally = Tally::default();
        for (number, breaks) in [(0, false), (1, true), (2, true), (3, false)] {
            tally.count(
                number,
                &CaseResult {
                    violated: breaks.then(|| broken("echoed")).into_iter().collect(),
                    margins: [("echoed".to_owned(), 0.0)].into(),
                    ..CaseResult::ended("passed")
                },
            );
        }
        assert_eq!(tally.nearest["echoed"], (0.0, 1));
    }

    fn broken(property: &str) -> Violated {
        Violated { property: property.to_owned(), at_s: 0.0, what: String::new() }
    }

    #[test]
    fn threads_change_nothing() {
        let one = campaign(&Toy::default(), &settings(100, 1), tempfile::tempdir().unwrap().path());
        let four =
            campaign(&Toy::default(), &settings(100, 4), tempfile::tempdir().unwrap().path());
        assert_eq!(one, four);
    }

    /// Counts the cases that it carries out.
    struct Counted(AtomicU64);

    impl Executor for Counted {
        fn execute(&self, case: &Case) -> CaseResult {
            self.0.fetch_add(1, Ordering::Relaxed);
            let mut result = Toy::default().execute(case);
            // Nothing to shrink.
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

    /// Is stopped in the middle of shrinking.
    struct Stopped(AtomicU64);

    impl Executor for Stopped {
        fn execute(&self, case: &Case) -> CaseResult {
            self.0.fetch_add(1, Ordering::Relaxed);
            Toy::default().execute(case)
        }

        fn is_stopped(&self) -> bool {
            self.0.load(Ordering::Relaxed) >= 403
        }
    }

    #[test]
    fn shrinking_ends_when_the_campaign_is_to_stop() {
        let (folder, executor) = (tempfile::tempdir().unwrap(), Stopped(AtomicU64::new(0)));
        let stopped = campaign(&executor, &settings(400, 1), folder.path());
        assert!(stopped.stopped);
        assert_eq!(stopped.tally.cases, 400);
        assert_eq!((executor.0.load(Ordering::Relaxed), stopped.found.len()), (403, 1));
        // It goes on where it stopped.
        let resumed = campaign(&Toy::default(), &settings(400, 1), folder.path());
        let whole =
            campaign(&Toy::default(), &settings(400, 1), tempfile::tempdir().unwrap().path());
        assert_eq!(resumed.found, whole.found);
    }

    /// Gives up after this many cases, like an executor whose bench is interrupted.
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
