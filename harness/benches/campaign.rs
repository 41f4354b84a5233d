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
    for (base, devices) in [("laps-corrected", "paper"), ("laps-corrected-serial", "paper-serial")]
    {
        let prepared = prepared(base, devices);
        let executor = Simulated::new(prepared.clone(), Answers::default());
        let (horizon, result) = executor.without_faults(1);
        assert!(result.passed && result.violated.is_empty(), "{result:?}");
        println!("{devices}: a lap without faults goes on for {:.1} s", horizon.as_secs_f64());
        let space = Space::new(&prepared.plan, prepared.rig.struck(), horizon, 3, &[]);
        let mut search = Random::new(&space, 1);
        let cases: Vec<Case> = (0..CASES).map(|_| search.next()).collect();
        let plain: Vec<Case> = (0..CASES).map(|seed| Case { seed, ..Case::default() }).collect();
        report("nothing watched, no fault", &plain, |case| {
            simulate(&prepared, case.seed, &Answers::default(), &mut NullSink, &mut |_| true)
                .end
                .as_secs_f64()
        });
        report("properties watched, no fault", &plain, |case| watched(&prepared, case));
        report("properties watched, one to three faults", &cases, |case| {
            let mut prepared = prepared.clone();
            Arc::make_mut(&mut prepared.plan).faults = case.schedule.clone();
            watched(&prepared, case)
        });
        campaign(&prepared, &cases);
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
fn report(what: &str, cases: &[Case], run: impl Fn(&Case) -> f64) {
    let laps_per_s = median(|| {
        let cpu = processor_s();
        let bench_s: f64 = cases.iter().map(|case| black_box(run(case))).sum();
        bench_s / LAP_S / (processor_s() - cpu)
    });
    println!("{what:<46} {laps_per_s:>8.0} laps/s of one core");
}

/// Cases of a campaign, which share beginnings: per second of processor time, and by the clock on the wall on all cores.
#[expect(clippy::disallowed_methods, reason = "a benchmark of many threads takes the time of day")]
fn campaign(prepared: &Prepared, cases: &[Case]) {
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
    println!("{:<46} {rate:>8.0} cases/s of one core", "a campaign's cases");
    let began = Instant::now();
    let rate = rates(threads, &|| began.elapsed().as_secs_f64());
    println!("{:<46} {rate:>8.0} cases/s on {threads} threads", "a campaign's cases");
}
