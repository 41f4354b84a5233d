//! Number of runs to find mutants of the controller: guided by margins, and by chance.
//!
//! `cargo bench -p tests --bench search [-- NAME...]` prints the table of docs/campaigns.md, for all mutants or for
//! those with one of these words in their names. It counts runs and measures no times. A mutant is found by a case in
//! which a property breaks that holds in the same case without the mutant.

#![expect(clippy::expect_used, reason = "a benchmark that cannot go on ends")]

mod plans;
mod score;

use campaign::seeds::for_each_seed;
use campaign::{Case, Executor as _, Guided, Random, Search, Space};
use controller::Mutant;
use harness::executors::Simulated;
use harness::operator::Answers;
use score::{Score, cell, ratio_and_interval};
use std::collections::{BTreeSet, VecDeque};
use std::num::NonZeroUsize;

/// Campaigns with each search for each mutant.
const CAMPAIGNS: u64 = 15;
/// Runs after which a campaign gives up.
const RUNS_MAX: u64 = 600;
/// Maximum number of faults in a run.
const FAULTS_MAX: usize = 3;
/// Runs that are drawn before the result of the first is known, if many run in parallel.
const AHEAD: usize = 64;

/// Search strategy.
#[derive(Debug, Clone, Copy)]
enum By {
    /// Each run learns from all runs before it.
    Margins,
    /// With [`AHEAD`] runs in parallel.
    MarginsAhead,
    Chance,
}

impl By {
    const ALL: [Self; 3] = [Self::Margins, Self::MarginsAhead, Self::Chance];

    fn search(self, space: &Space, seed: u64) -> (Box<dyn Search>, usize) {
        match self {
            Self::Margins => (Box::new(Guided::new(space, seed)), 1),
            Self::MarginsAhead => (Box::new(Guided::new(space, seed)), AHEAD),
            Self::Chance => (Box::new(Random::new(space, seed)), 1),
        }
    }
}

/// A mutant, and the bench with and without it.
struct Hunt {
    with: Simulated,
    without: Simulated,
    space: Space,
}

impl Hunt {
    fn new(mutant: Mutant) -> Self {
        let sound = plans::prepared(mutant);
        let mut mistaken = sound.clone();
        mistaken.mutant = Some(mutant);
        let without = Simulated::new(sound.clone(), Answers::default());
        let (horizon, result) = without.without_faults(1);
        assert!(result.passed && result.violated.is_empty(), "{result:?}");
        let lines = sound.rig.struck();
        let space = Space::new(&sound.plan, lines, horizon, FAULTS_MAX, &[]);
        Self { with: Simulated::new(mistaken, Answers::default()), without, space }
    }

    /// Returns the number of runs until a case breaks a property that holds in the same case without the mutant, and
    /// the property.
    fn needed(&self, by: By, seed: u64) -> Option<(u64, String)> {
        let (mut search, ahead) = by.search(&self.space, seed);
        let mut drawn: VecDeque<Case> = VecDeque::new();
        for run in 1..=RUNS_MAX {
            // The first run has no faults: some mutants need none.
            let case = if run == 1 {
                Case { seed, ..Case::default() }
            } else {
                while drawn.len() < ahead {
                    drawn.push_back(search.next());
                }
                drawn.pop_front()?
            };
            let result = self.with.execute(&case);
            if !result.violated.is_empty() {
                let right = self.without.execute(&case);
                if let Some(new) = result.violated.iter().find(|v| !right.breaks(&v.property)) {
                    return Some((run, new.property.clone()));
                }
            }
            if run > 1 {
                search.learn(&case, &result);
            }
        }
        None
    }
}

fn main() {
    let asked: Vec<String> =
        std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    let is_asked = |name: &str| asked.is_empty() || asked.iter().any(|word| name.contains(word));
    let threads = std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN);
    println!("| mistake | by margins | {AHEAD} ahead | by chance | property |");
    println!("|---|---|---|---|---|");
    let (mut one, mut ahead) = (Vec::new(), Vec::new());
    let mut medians = [0; By::ALL.len()];
    for &mutant in Mutant::ALL.iter().filter(|mutant| is_asked(mutant.name())) {
        let hunt = Hunt::new(mutant);
        let mut properties = BTreeSet::new();
        let scores = By::ALL.map(|by| {
            let found =
                for_each_seed(1..1 + CAMPAIGNS, threads, &|seed| Some(hunt.needed(by, seed)));
            let runs = found.iter().map(|(_, found)| found.as_ref().map(|(runs, _)| *runs));
            let runs = runs.collect();
            properties.extend(found.into_iter().filter_map(|(_, found)| Some(found?.1)));
            Score { runs, runs_max: RUNS_MAX }
        });
        let cells = scores.each_ref().map(cell).join(" | ");
        let properties: Vec<String> = properties.into_iter().collect();
        println!("| {} | {cells} | {} |", mutant.name(), properties.join(", "));
        for (sum, score) in medians.iter_mut().zip(&scores) {
            *sum += score.median();
        }
        let [margins, margins_ahead, chance] = scores;
        // A mutant found in the first run says nothing about a search.
        if chance.median() > 1 {
            one.push((margins, chance.clone()));
            ahead.push((margins_ahead, chance));
        }
    }
    println!("| sum of medians | {} | |", medians.map(|sum| sum.to_string()).join(" | "));
    let ratios = [&one, &ahead].map(|pairs| {
        let (ratio, low, high) = ratio_and_interval(pairs);
        format!("{ratio:.2} ({low:.2} to {high:.2})")
    });
    println!("| runs over those by chance | {} | 1 | |", ratios.join(" | "));
}
