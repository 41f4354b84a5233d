//! Runs a plan under many seeds: a single run is an anecdote, a share of many has an interval.

use plan::Plan;
use plan::confidence::{Z_95, wilson};
use record::outcome::{Measurement, Outcome, PropertySummary};
use serde::Serialize;
use std::num::{NonZeroU64, NonZeroUsize};
use std::ops::Range;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;

/// Runs `job` once for every seed, on `threads` threads, and returns the results in the order of the seeds. Once a job
/// returns `None`, no further seed begins, and the results so far are returned.
///
/// # Panics
///
/// When a job panics.
pub fn for_each_seed<T: Send>(
    seeds: Range<u64>,
    threads: NonZeroUsize,
    job: &(impl Fn(u64) -> Option<T> + Sync),
) -> Vec<(u64, T)> {
    let count = seeds.end.saturating_sub(seeds.start);
    let next = AtomicU64::new(0);
    let stopped = AtomicBool::new(false);
    let work = || {
        let mut done = Vec::new();
        while !stopped.load(Ordering::Relaxed) {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= count {
                break;
            }
            let seed = seeds.start + index;
            match job(seed) {
                Some(result) => done.push((seed, result)),
                None => stopped.store(true, Ordering::Relaxed),
            }
        }
        done
    };
    let mut results: Vec<_> = thread::scope(|scope| {
        let workers: Vec<_> = (0..threads.get()).map(|_| scope.spawn(work)).collect();
        let done = workers
            .into_iter()
            .map(|worker| worker.join().unwrap_or_else(|panic| resume_unwind(panic)));
        done.flatten().collect()
    });
    results.sort_by_key(|(seed, _)| *seed);
    results
}

/// Result of one plan under one seed, reduced to what a share needs.
#[derive(Debug, Clone, PartialEq)]
pub struct SeedVerdicts {
    /// Why the run did not reach its end: its outcome and a sentence.
    pub broke_off: Option<(Outcome, String)>,
    /// Whether each measurement was acceptable, in the order of the plan. In an incomplete run none is, because the
    /// missing ones might have failed.
    pub accepted: Vec<bool>,
    /// Each figure with its standard uncertainty, in the same order; `None` if it was not measured.
    pub figures: Vec<Option<(f64, f64)>>,
    /// Whether each property held, in the order of the plan; none in an incomplete run, which might have broken it.
    pub held: Vec<bool>,
    /// Whether each property held because nothing asked for it, in the same order.
    pub never_asked: Vec<bool>,
}

impl SeedVerdicts {
    /// The result of a run with this outcome, reason, measurements and properties.
    pub fn of(
        ended: Outcome,
        reason: Option<&str>,
        measurements: &[Measurement],
        properties: &[PropertySummary],
    ) -> Self {
        let complete = ended == Outcome::Passed;
        let accepted = |one: &Measurement| complete && one.verdict.is_acceptable();
        Self {
            broke_off: (!complete).then(|| (ended, reason.unwrap_or_default().to_owned())),
            accepted: measurements.iter().map(accepted).collect(),
            figures: measurements
                .iter()
                .map(|one| one.value.filter(|_| complete).map(|value| (value, one.uncertainty)))
                .collect(),
            held: properties.iter().map(|one| complete && one.held == Some(true)).collect(),
            never_asked: properties.iter().map(|one| one.never_asked.is_some()).collect(),
        }
    }

    fn passed(&self) -> bool {
        self.accepted.iter().chain(&self.held).all(|good| *good) && self.broke_off.is_none()
    }
}

/// What a share is of, by name.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Judged {
    /// A measurement that was acceptable.
    Measurement(String),
    /// A property that held.
    Property(String),
}

/// The share of seeds for which a measurement was acceptable or a property held.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SeedShare {
    /// The plan.
    pub plan: String,
    /// The measurement or property.
    #[serde(flatten)]
    pub judged: Judged,
    /// Number of seeds whose run passed it, marginally or not.
    pub passed: u64,
    /// Number of these in which a property held because nothing asked for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub never_asked: Option<NonZeroU64>,
    /// Number of seeds that ran.
    pub seeds: u64,
    /// 95 % Wilson interval of the share, lower and upper end, from 0 to 1.
    pub interval: (f64, f64),
    /// How often the stated 95 % interval of a run contained the mean over all seeds; `None` for a figure that is not
    /// an estimate from many values, or that is the same in every run.
    pub coverage: Option<Coverage>,
    /// The value in the paper, with its place there.
    pub paper: Option<String>,
}

/// How many of the intervals that runs state contain the true value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Coverage {
    /// Number that do.
    pub held: u64,
    /// Number of intervals.
    pub of: u64,
}

impl Coverage {
    /// Coverage of figures with their standard uncertainties. The mean stands in for the true value; its uncertainty is
    /// `1 / sqrt(n)` of the spread of a run.
    fn of(figures: &[(f64, f64)]) -> Option<Self> {
        let first = figures.first()?;
        if figures.iter().all(|figure| figure == first) {
            return None;
        }
        let mean = figures.iter().map(|(value, _)| value).sum::<f64>() / figures.len() as f64;
        let held = figures.iter().filter(|(value, u)| (value - mean).abs() <= Z_95 * u).count();
        Some(Self { held: held as u64, of: figures.len() as u64 })
    }
}

/// The share of seeds for which each measurement of `plan` was acceptable, then those for which each property held,
/// with 95 % Wilson intervals.
pub fn shares(plan: &Plan, runs: &[(u64, &SeedVerdicts)]) -> Vec<SeedShare> {
    let share = |judged, good: &dyn Fn(&SeedVerdicts) -> bool| {
        let passed = runs.iter().filter(|(_, run)| good(run)).count() as u64;
        let seeds = runs.len() as u64;
        let interval = wilson(passed, seeds, Z_95);
        SeedShare {
            plan: plan.name.as_str().to_owned(),
            judged,
            passed,
            never_asked: None,
            seeds,
            // Without a seed the share may be anything.
            interval: interval.map_or((0.0, 1.0), |interval| (interval.lower, interval.upper)),
            coverage: None,
            paper: None,
        }
    };
    let measured = plan.measurements.iter().enumerate().map(|(index, declared)| {
        let figures = runs.iter().filter_map(|(_, run)| *run.figures.get(index)?);
        let figures: Vec<_> = figures.filter(|_| declared.check.kind().facts().estimates).collect();
        let judged = Judged::Measurement(declared.name.as_str().to_owned());
        let paper = declared.paper.clone();
        let share = share(judged, &|run| run.accepted.get(index) == Some(&true));
        SeedShare { coverage: Coverage::of(&figures), paper, ..share }
    });
    let watched = plan.properties.iter().enumerate().map(|(index, property)| {
        let judged = Judged::Property(property.name().to_owned());
        let held = |run: &SeedVerdicts| run.held.get(index) == Some(&true);
        let unasked = |run: &SeedVerdicts| held(run) && run.never_asked.get(index) == Some(&true);
        let never_asked = runs.iter().filter(|(_, run)| unasked(run)).count() as u64;
        SeedShare { never_asked: NonZeroU64::new(never_asked), ..share(judged, &held) }
    });
    measured.chain(watched).collect()
}

/// The seeds whose run did not pass, in order.
pub fn not_passed<'a>(runs: &[(u64, &'a SeedVerdicts)]) -> Vec<(u64, &'a SeedVerdicts)> {
    runs.iter().filter(|(_, run)| !run.passed()).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::{Coverage, Judged, SeedVerdicts, for_each_seed, not_passed, shares};
    use plan::Plan;
    use proptest::prelude::*;
    use record::outcome::Outcome;
    use std::num::{NonZeroU64, NonZeroUsize};

    fn threads(count: usize) -> NonZeroUsize {
        NonZeroUsize::new(count).unwrap()
    }

    proptest! {
        #[test]
        fn every_seed_runs_once_and_in_order(
            first in 0u64..u64::MAX - 100,
            count in 0u64..60,
            workers in 1usize..9,
        ) {
            // The duration of a job depends on the seed, so that threads overtake each other.
            let job = |seed: u64| {
                let spins = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) % 5_000;
                Some((0..spins).fold(seed, |a, b| std::hint::black_box(a ^ b ^ b)))
            };
            let one = for_each_seed(first..first + count, threads(1), &job);
            let many = for_each_seed(first..first + count, threads(workers), &job);
            prop_assert_eq!(&one, &many);
            let seeds: Vec<_> = many.iter().map(|(seed, _)| *seed).collect();
            prop_assert_eq!(seeds, (first..first + count).collect::<Vec<_>>());
        }
    }

    #[test]
    fn the_last_seeds_there_are_can_run() {
        let runs = for_each_seed(u64::MAX - 2..u64::MAX, threads(4), &Some);
        assert_eq!(runs.len(), 2);
    }

    #[test]
    fn nothing_begins_after_a_stop() {
        let runs = for_each_seed(0..1_000_000, threads(2), &|seed| (seed < 5).then_some(()));
        let seeds: Vec<_> = runs.iter().map(|(seed, ())| *seed).collect();
        assert_eq!(seeds, [0, 1, 2, 3, 4]);
    }

    const PLAN: &str = r#"
name = "turns"
title = "Turns"
devices = "paper"
steps = [{ turn = { angle_deg = 90 } }]

[[measurement]]
name = "stop"
doc = "Stop error"
quantity = "turn.stop_error"
unit = "deg"
check = { all_within = [-1, 1] }
paper = "mostly"
"#;

    fn plan() -> Plan {
        Plan::parse("turns.toml", PLAN).unwrap()
    }

    fn run(accepted: bool) -> SeedVerdicts {
        SeedVerdicts {
            broke_off: None,
            accepted: vec![accepted],
            figures: vec![None],
            held: Vec::new(),
            never_asked: Vec::new(),
        }
    }

    #[test]
    fn coverage_is_of_the_mean_over_the_seeds() {
        let held = |figures: &[(f64, f64)]| Coverage::of(figures).map(|one| (one.held, one.of));
        assert_eq!(held(&[(1.0, 0.1), (3.0, 0.1), (2.1, 0.1), (1.9, 0.01)]), Some((1, 4)));
        assert_eq!(held(&[(1.0, 0.1), (1.0, 0.1)]), None, "nothing is random in it");
        assert_eq!(held(&[]), None);
    }

    #[test]
    fn a_share_counts_the_acceptable() {
        let broke_off = Some((Outcome::Timeout, "too long".to_owned()));
        let (good, bad) = (run(true), run(false));
        let broken = SeedVerdicts { broke_off, ..run(false) };
        let runs = [(3, &good), (4, &bad), (5, &broken), (6, &good)];
        let shares = shares(&plan(), &runs);
        assert_eq!(shares.len(), 1);
        assert_eq!((shares[0].passed, shares[0].seeds), (2, 4));
        assert!(shares[0].interval.0 > 0.1 && shares[0].interval.1 < 0.9);
        assert_eq!(shares[0].paper.as_deref(), Some("mostly"));
        let seeds: Vec<_> = not_passed(&runs).iter().map(|(seed, _)| *seed).collect();
        assert_eq!(seeds, [4, 5]);
    }

    #[test]
    fn a_property_has_a_share_of_its_own() {
        let with_property = format!("{PLAN}\n[[property]]\nalways = {{ done_is_done = {{}} }}\n");
        let plan = Plan::parse("turns.toml", &with_property).unwrap();
        let held = SeedVerdicts { held: vec![true], never_asked: vec![true], ..run(true) };
        let broken = SeedVerdicts { held: vec![false], ..run(true) };
        let runs = [(1, &held), (2, &broken)];
        let shares = shares(&plan, &runs);
        assert_eq!(shares[0].passed, 2);
        assert_eq!(shares[1].judged, Judged::Property("done_is_done".to_owned()));
        // Found by a user: nothing told that it was never put to the test.
        assert_eq!((shares[1].passed, shares[1].never_asked), (1, NonZeroU64::new(1)));
        let seeds: Vec<_> = not_passed(&runs).iter().map(|(seed, _)| *seed).collect();
        assert_eq!(seeds, [2]);
    }

    #[test]
    fn no_seed_says_nothing() {
        assert_eq!(shares(&plan(), &[])[0].interval, (0.0, 1.0));
    }
}
