//! Number of executions to find and shrink a defect that needs four steps in order: our search and shrinking compared
//! with proptest-state-machine, on the same model with the same strategies for steps.
//!
//! `cargo bench -p tests --bench four_steps` prints the table of docs/campaigns.md. It measures no times.

#![expect(clippy::expect_used, reason = "a benchmark that cannot go on ends")]

mod model;

use campaign::{Executor as _, Guided, Random, Search, Space, shrink};
use model::{Alphabet, FourSteps, HELD, LENGTH_MAX, Taken};
use plan::faults::Fault;
use proptest::strategy::{Just, Strategy as _};
use proptest::test_runner::{Config, RngSeed, TestCaseError, TestError, TestRunner};
use proptest_state_machine::Sequential;
use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Campaigns with each.
const CAMPAIGNS: u64 = 25;
/// Maximum number of executions.
const EXECUTIONS_MAX: u32 = 1_000_000;

/// Cost of one campaign.
#[derive(Debug, Clone, Copy)]
struct Took {
    /// Executions up to the first failure.
    found: u64,
    /// Total executions.
    all: u64,
    /// Steps of the smallest sequence.
    steps: usize,
}

fn ours(space: &Space, search: &mut dyn Search) -> Option<Took> {
    for found in 1..=u64::from(EXECUTIONS_MAX) {
        let case = search.next();
        let result = FourSteps.execute(&case);
        search.learn(&case, &result);
        if result.breaks(HELD) {
            let shrunk = shrink(&FourSteps, &case, &result, HELD, EXECUTIONS_MAX.into());
            assert!(space.takes(&shrunk.case.schedule));
            let steps = shrunk.case.schedule.faults.len();
            return Some(Took { found, all: found + shrunk.executions, steps });
        }
    }
    None
}

/// Runs a sequence as its `test_sequential` does, and counts the steps taken, but does not panic.
fn state_machine(space: &Space, seed: u64) -> Option<Took> {
    let space = space.clone();
    let sequences = Sequential::new(
        (1..=LENGTH_MAX).into(),
        || Just(Taken::default()),
        |_: &Taken, _: &Fault| true,
        move |_: &Taken| space.fault(),
        |taken: Taken, fault: &Fault| taken.after(fault),
    );
    let config = Config {
        cases: EXECUTIONS_MAX,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(seed),
        ..Config::default()
    };
    let (all, found) = (Cell::new(0), Cell::new(None));
    let broken = TestRunner::new(config).run(&sequences.prop_map(WithCounter), |sequence| {
        all.set(all.get() + 1);
        let WithCounter((mut taken, steps, seen)) = sequence;
        for step in steps {
            if let Some(seen) = &seen {
                seen.fetch_add(1, Ordering::SeqCst);
            }
            taken = taken.after(&step);
            if taken.is_broken() {
                found.set(found.get().or(Some(all.get())));
                return Err(TestCaseError::fail("the fourth step"));
            }
        }
        Ok(())
    });
    let Err(TestError::Fail(_, WithCounter((_, steps, _)))) = broken else { return None };
    Some(Took { found: found.get()?, all: all.get(), steps: steps.len() })
}

/// Output of the strategy: the initial state, the steps, and a counter of those taken.
#[derive(Debug, Clone)]
struct WithCounter((Taken, Vec<Fault>, Option<Arc<AtomicUsize>>));

fn median(mut of: Vec<u64>) -> u64 {
    of.sort_unstable();
    of.get(of.len() / 2).copied().unwrap_or_default()
}

fn row(alphabet: &str, name: &str, took: &[Option<Took>]) {
    let found: Vec<Took> = took.iter().flatten().copied().collect();
    let of = |what: fn(&Took) -> u64| found.iter().map(what).collect::<Vec<u64>>();
    let mean = of(|took| took.all).iter().sum::<u64>() as f64 / found.len().max(1) as f64;
    println!(
        "| {alphabet} | {name} | {} | {} | {} ({mean:.0}) | {} | {} |",
        median(of(|took| took.found)),
        median(of(|took| took.all - took.found)),
        median(of(|took| took.all)),
        found.iter().map(|took| took.steps).max().unwrap_or_default(),
        took.len() - found.len(),
    );
}

fn main() {
    println!(
        "| steps of | search | to find | to make small | all, median (mean) | steps left, most | not found |"
    );
    println!("|---|---|---|---|---|---|---|");
    for alphabet in Alphabet::ALL {
        let space = alphabet.space();
        let kinds = format!("{} kinds", space.kinds().len());
        let seeds = 1..=CAMPAIGNS;
        let guided: Vec<_> =
            seeds.clone().map(|seed| ours(&space, &mut Guided::new(&space, seed))).collect();
        row(&kinds, "by margins", &guided);
        let chance: Vec<_> =
            seeds.clone().map(|seed| ours(&space, &mut Random::new(&space, seed))).collect();
        row(&kinds, "by chance", &chance);
        let theirs: Vec<_> = seeds.map(|seed| state_machine(&space, seed)).collect();
        row(&kinds, "proptest-state-machine", &theirs);
    }
}
