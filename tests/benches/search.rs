//! How many runs it takes to find mistakes that are planted in the controller: by margins, and by chance.
//!
//! `cargo bench -p tests --bench search` prints the table of docs/campaigns.md. No time is taken: runs are counted. A
//! mistake is found by a case in which a property breaks that holds in the same case without the mistake.

#![expect(clippy::expect_used, reason = "a benchmark that cannot go on ends")]

use controller::Mutant;
use harness::campaign::{Case, Executor as _, Guided, Random, Search, Simulated, Space};
use harness::made::Made;
use harness::operator::Answers;
use harness::plan::Plan;
use harness::run::Prepared;
use harness::seeds::for_each_seed;
use harness::world::bench::bench_lines;
use std::num::NonZeroUsize;
use std::sync::Arc;

/// Campaigns of each kind for each mistake.
const CAMPAIGNS: u64 = 15;
/// Runs after which a campaign gives up.
const RUNS_MAX: u64 = 600;

/// Two small squares, one each way, with a bias test before each.
const PLAN: &str = r#"
name = "two-squares"
title = "A square of a metre each way"
devices = "paper-robot"
steps = [
    { use_calibration = "temperature" },
    { place = { x_m = 0, y_m = 0, heading_deg = 0 } },
    { bias_test = { duration_s = 20 } },
    { lap = { direction = "cw", side_m = 1, speed_m_per_s = 0.4, turn_rate_deg_per_s = 30 } },
    { bias_test = { duration_s = 20 } },
    { lap = { direction = "ccw", side_m = 1, speed_m_per_s = 0.4, turn_rate_deg_per_s = 30 } },
]

[[measurement]]
name = "return_heading"
doc = "Heading after a lap"
quantity = "lap.return_heading"
unit = "deg"
check = { all_within = [-1.2, 1.2] }
"#;

fn prepared(mutant: Option<Mutant>) -> Prepared {
    let mut prepared = Prepared::load("laps-corrected", &Made::default()).expect("the plan ships");
    prepared.plan = Arc::new(Plan::parse("two-squares.toml", PLAN).expect("a good plan"));
    prepared.mutant = mutant;
    prepared
}

/// Runs until a case breaks a property that holds in the same case without the mistake, and which it was.
fn needed(mutant: Mutant, search: &mut dyn Search) -> Option<(u64, String)> {
    let with = Simulated::new(prepared(Some(mutant)), Answers::default());
    let without = Simulated::new(prepared(None), Answers::default());
    for run in 1..=RUNS_MAX {
        // Nothing goes wrong in the first: some mistakes need no fault.
        let case = if run == 1 { Case { seed: 1, ..Case::default() } } else { search.next() };
        let result = with.execute(&case);
        if run > 1 {
            search.learn(&case, &result);
        }
        if !result.violated.is_empty() {
            let right = without.execute(&case);
            if let Some(new) = result.violated.iter().find(|v| !right.breaks(&v.property)) {
                return Some((run, new.property.clone()));
            }
        }
    }
    None
}

fn main() {
    let base = prepared(None);
    let clean = Simulated::new(base.clone(), Answers::default());
    let (horizon, result) = clean.without_faults(1);
    assert!(result.passed && result.violated.is_empty(), "{result:?}");
    let space = Space::new(&base.plan, bench_lines(&base.devices), horizon, 3, &[]);
    println!("| mistake | by margins | not found | by chance | not found | property |");
    println!("|---|---|---|---|---|---|");
    let threads = std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN);
    for &mutant in Mutant::ALL {
        let mut row = format!("| {} |", mutant.name());
        let mut properties: Vec<String> = Vec::new();
        for guided in [true, false] {
            let job = |seed: u64| {
                let mut search: Box<dyn Search> = if guided {
                    Box::new(Guided::new(&space, seed))
                } else {
                    Box::new(Random::new(&space, seed))
                };
                Some(needed(mutant, &mut *search))
            };
            let found = for_each_seed(1..1 + CAMPAIGNS, threads, &job);
            let mut runs: Vec<u64> =
                found.iter().map(|(_, found)| found.as_ref().map_or(RUNS_MAX, |f| f.0)).collect();
            runs.sort_unstable();
            let missed = found.iter().filter(|(_, found)| found.is_none()).count();
            for (_, property) in found.into_iter().filter_map(|(_, found)| found) {
                if !properties.contains(&property) {
                    properties.push(property);
                }
            }
            row += &format!(" {} | {missed} of {CAMPAIGNS} |", runs[runs.len() / 2]);
        }
        println!("{row} {} |", properties.join(", "));
    }
}
