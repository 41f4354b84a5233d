//! Throughput of a campaign in faulted laps, with every byte and frame carried and all properties judged.
//!
//! `cargo bench -p harness --bench campaign`. A case is a bias test and one lap (4 m sides, 0.4 m/s, 30 deg/s) with one
//! to three faults drawn from all that can strike. The figure counts bench time, in laps of 64 s: a case that ends
//! early counts for the time that it lasted.

mod processor;

use campaign::seeds::for_each_seed;
use campaign::{Case, Executor as _, Random, Search as _, Space};
use harness::executors::Simulated;
use harness::run::{Prepared, simulate, simulate_watched};
use plan::Plan;
use plan::made::Made;
use processor::{median, processor_s};
use record::sink::NullSink;
use rig::operator::Answers;
use std::hint::black_box;
use std::num::NonZeroUsize;
use std::sync::Arc;
use std::time::Instant;

/// Cases of one round.
const CASES: u64 = 400;
/// Duration of one lap.
const LAP_S: f64 = 64.0;

const PLAN: &str = r#"
name = "one-lap"
title = "One lap of a square of 4 m"
devices = "DEVICES"
steps = [
    { use_calibration = "temperature" },
    { place = { x_m = 0, y_m = 0, heading_deg = 0 } },
    { bias_test = { duration_s = 20 } },
    { lap = { direction = "cw", side_m = 4, speed_m_per_s = 0.4, turn_rate_deg_per_s = 30 } },
]

[[measurement]]
name = "return_heading"
doc = "Heading after the lap"
quantity = "lap.return_heading"
unit = "deg"
check = { all_within = [-1.2, 1.2] }
"#;

fn main() {
    // `cargo test --benches` only checks that it starts.
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    println!("| base | what | figure | aim |\n|---|---|---|---|");
    for (base, devices) in [("laps-corrected", "paper"), ("laps-corrected-serial", "paper-serial")]
    {
        let prepared = prepared(base, devices);
        let executor = Simulated::new(prepared.clone(), Answers::default());
        let (horizon, result) = executor.without_faults(1);
        assert!(result.passed && result.violated.is_empty(), "{result:?}");
        let base = if devices == "paper" { "CAN" } else { "serial" };
        let space = Space::new(&prepared.plan, prepared.rig.struck(), horizon, 3, &[]);
        let mut search = Random::new(&space, 1);
        let cases: Vec<Case> = (0..CASES).map(|_| search.next()).collect();
        let plain: Vec<Case> = (0..CASES).map(|seed| Case { seed, ..Case::default() }).collect();
        report(base, "no fault, no property", &plain, |case| {
            simulate(&prepared, case.seed, &Answers::default(), &mut NullSink, &mut |_| true)
                .end
                .as_secs_f64()
        });
        report(base, "all properties", &plain, |case| watched(&prepared, case));
        report(
            base,
            "all properties, one to three faults, each from the beginning",
            &cases,
            |case| {
                let mut prepared = prepared.clone();
                Arc::make_mut(&mut prepared.plan).faults = case.schedule.clone();
                watched(&prepared, case)
            },
        );
        campaign(base, &prepared, &cases);
    }
}

/// One lap, with the calibrations of the plan `base` and its `devices`.
fn prepared(base: &str, devices: &str) -> Prepared {
    let mut prepared = Prepared::load(base, &Made::default()).expect("it ships");
    let text = PLAN.replace("DEVICES", devices);
    prepared.plan = Arc::new(Plan::parse("one-lap.toml", &text).expect("a good plan"));
    prepared
}

/// Bench time of the run, s.
fn watched(prepared: &Prepared, case: &Case) -> f64 {
    let (seed, answers) = (case.seed, Answers::default());
    let run = simulate_watched(prepared, seed, &answers, &mut NullSink, &mut |_| true);
    run.end.as_secs_f64()
}

/// Laps per second of processor time.
fn report(base: &str, what: &str, cases: &[Case], run: impl Fn(&Case) -> f64) {
    let laps_per_s = median(|| {
        let cpu = processor_s();
        let bench_s: f64 = cases.iter().map(|case| black_box(run(case))).sum();
        bench_s / LAP_S / (processor_s() - cpu)
    });
    println!("| {base} | {what} | {laps_per_s:.0} laps/s of one core | |");
}

/// Cases of a campaign, which share beginnings: per second of processor time, and by the clock on the wall on all cores.
#[expect(clippy::disallowed_methods, reason = "a benchmark of many threads takes the time of day")]
fn campaign(base: &str, prepared: &Prepared, cases: &[Case]) {
    let threads = std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN);
    let rates = |threads: NonZeroUsize, clock: &dyn Fn() -> f64| {
        median(|| {
            let executor = Simulated::new(prepared.clone(), Answers::default());
            let job = |index: u64| Some(executor.execute(&cases[index as usize]));
            let began = clock();
            let done = for_each_seed(0..CASES, threads, &job).len() as f64;
            done / (clock() - began)
        })
    };
    let rate = rates(NonZeroUsize::MIN, &processor_s);
    aimed(base, rate, "of one core", 500.0);
    let began = Instant::now();
    let rate = rates(threads, &|| began.elapsed().as_secs_f64());
    aimed(base, rate, &format!("on {threads} threads, by the clock on the wall"), 1_000.0);
}

fn aimed(base: &str, rate: f64, on: &str, aim: f64) {
    let met = if rate >= aim { "met" } else { "missed" };
    println!("| {base} | cases of a campaign | {rate:.0} cases/s {on} | {aim:.0}, {met} |");
}
