//! The tolerance for one kind of fault: results of runs at increasing severity.
//!
//! A run passes, or it fails and the controller reported that, or it fails without a report: silently wrong. A silent
//! failure is worse than a reported one, so they are counted separately.

use super::case::{Case, CaseResult};
use super::course::Course;
use super::executor::Executor;
use super::space::severity;
use emulators::random::RandomStream;
use plan::Name;
use plan::confidence::{Z_95, wilson};
use plan::faults::{Fault, FaultKind, Lasts, Schedule, Target, When};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use wire::time::Span;

/// Settings for measuring an envelope.
#[derive(Debug, Clone, PartialEq)]
pub struct EnvelopeSettings {
    /// The most runs at each severity, each with its own seed; fewer if they suffice for a decision.
    pub runs: u64,
    /// A severity is tolerated if at least this share of runs passes, at 95 % confidence.
    pub share: f64,
    /// The first seed.
    pub seed: u64,
    /// A severity that is run in any case: the requested one.
    pub asked: Option<f64>,
    /// How the plan goes by without faults. A fault with its own duration, or at an instant, begins at a time within
    /// it, drawn from the seed of each run.
    pub course: Course,
    /// The phases with motion, if the plan moves after a bias test. Faults act there, because an earlier one would be a
    /// fault of the test. The first phase is the earliest.
    pub motions: Vec<(Name, u32)>,
    /// The states that the plan demands: a run that does not reach them all fails.
    pub demanded: BTreeSet<String>,
    /// Whether the controller takes missions and reports its health, so that a failure can have been announced.
    pub tells: bool,
    /// Number of parallel runs.
    pub threads: NonZeroUsize,
}

impl EnvelopeSettings {
    /// The most runs of an envelope: those without a fault, the ladder and the steps below it, the bisection, and the
    /// requested severity.
    pub fn runs_max(&self) -> u64 {
        let levels = 1 + LADDER + BELOW + HALVINGS + usize::from(self.asked.is_some());
        self.runs.saturating_mul(levels as u64)
    }

    /// Whether a severity is tolerated according to its runs.
    fn tolerates(&self, level: &Level) -> bool {
        level.interval.0 >= self.share
    }
}

/// Results of the runs at one severity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Level {
    /// In the unit of the kind's first parameter; zero without a fault.
    pub severity: f64,
    /// Number of runs that passed.
    pub passed: u64,
    /// Number of failed runs whose controller reported it: it stopped, refused, or reported bad health.
    #[serde(default)]
    pub announced: u64,
    /// Number of failed runs whose controller reported nothing, or too late: silently wrong.
    #[serde(default)]
    pub silent: u64,
    /// Number of runs. Without a controller that takes missions, failed runs are neither announced nor silent.
    pub runs: u64,
    /// 95 % interval of the pass probability (Wilson).
    pub interval: (f64, f64),
}

impl Level {
    /// Share of runs that passed.
    pub fn share(&self) -> f64 {
        if self.runs > 0 { self.passed as f64 / self.runs as f64 } else { 0.0 }
    }
}

/// The share of runs that pass, over the severity of one kind.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Envelope {
    /// The kind.
    pub kind: String,
    /// The target.
    pub target: String,
    /// Unit of severities.
    pub unit: String,
    /// Required share of passing runs.
    pub share: f64,
    /// Results, the mildest severity first.
    pub levels: Vec<Level>,
    /// The greatest severity for which it holds, as for every smaller one that was run, that the lower end of the
    /// interval is at least `share`; `None` if not even the smallest is tolerated.
    pub tolerated: Option<f64>,
    /// Whether everything up to the end of the range is tolerated.
    pub is_all: bool,
}

impl Envelope {
    /// The level without any fault, if too few of its runs passed: then no other was measured.
    pub fn fails_by_itself(&self) -> Option<&Level> {
        let first = self.levels.first().filter(|level| level.severity == 0.0);
        first.filter(|level| level.interval.0 < self.share)
    }

    /// Whether failed runs are announced or silent: there is a controller that takes missions.
    pub fn tells(&self) -> bool {
        self.levels.iter().any(|level| level.announced + level.silent > 0)
    }

    /// The severity with the largest share of silent failures; `None` if there were none.
    pub fn most_silent(&self) -> Option<&Level> {
        let share = |level: &Level| level.silent as f64 / level.runs as f64;
        let silent = self.levels.iter().filter(|level| level.silent > 0);
        silent.max_by(|a, b| share(a).total_cmp(&share(b)))
    }

    /// Whether this severity, and every smaller one that was run, is tolerated.
    pub fn tolerates(&self, severity: f64) -> bool {
        self.tolerated.is_some_and(|most| most >= severity)
    }
}

/// An envelope and its requirement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// The plan that ran.
    pub plan: String,
    /// The measured envelope.
    #[serde(flatten)]
    pub envelope: Envelope,
    /// The severity that must be tolerated, if requested.
    pub at_least: Option<f64>,
}

impl Measured {
    /// Whether the requested severity is tolerated; true without a request.
    pub fn holds(&self) -> bool {
        self.at_least.is_none_or(|least| self.envelope.tolerates(least))
    }
}

/// Number of severities in the first pass, in even logarithmic steps.
const LADDER: usize = 9;
/// Number of severities below those, each a tenth of the previous, if not even the smallest is tolerated.
const BELOW: usize = 3;
/// Number of bisections between a tolerated severity and the next one that is not.
const HALVINGS: usize = 4;
/// Runs in the first round at a severity; each further round doubles the total.
const ROUND: u64 = 20;
/// A round decides by an interval of 99 %, because several rounds are evaluated and each may be wrong.
const Z_ROUND: f64 = 2.575_829_303_548_901;

/// Measures the envelope of `fault` with one executor: no fault, a ladder over the whole range of severity, tenths
/// below it if the smallest is too much, then a bisection between the last tolerated step and the next. A plan that
/// [fails without any fault](Envelope::fails_by_itself) shows nothing about the fault: it is measured no further.
/// `pulse` receives each level; returning false stops.
pub fn envelope(
    executor: &impl Executor,
    fault: &Fault,
    settings: &EnvelopeSettings,
    pulse: &mut dyn FnMut(&Level) -> bool,
) -> Envelope {
    let info = fault.what.info();
    let mut levels: Vec<Level> = Vec::new();
    let mut goes_on = true;
    let mut measure = |severity: f64, levels: &mut Vec<Level>| -> Option<bool> {
        if !goes_on {
            return None;
        }
        let level = at(executor, fault, severity, settings);
        goes_on = pulse(&level);
        levels.push(level);
        Some(settings.tolerates(&level))
    };
    let rung = |step: usize| severity(fault.what, step as f64 / (LADDER - 1) as f64);
    let passes_by_itself = measure(0.0, &mut levels) == Some(true);
    let (mut good, mut bad) = (None, None);
    for step in (0..LADDER).filter(|_| passes_by_itself) {
        match measure(rung(step), &mut levels) {
            Some(true) if bad.is_none() => good = Some(rung(step)),
            Some(false) if bad.is_none() => bad = Some(rung(step)),
            None => break,
            // Higher severities complete the picture: runs may pass again.
            Some(_) => {}
        }
    }
    if good.is_none() && passes_by_itself {
        for severity in below(fault.what, rung(0)) {
            match measure(severity, &mut levels) {
                Some(true) => good = Some(severity),
                Some(false) => bad = Some(severity),
                None => break,
            }
            if good.is_some() {
                break;
            }
        }
    }
    if let (Some(mut good), Some(mut bad)) = (good, bad) {
        for _ in 0..HALVINGS {
            let middle = (good * bad).sqrt();
            match measure(middle, &mut levels) {
                Some(true) => good = middle,
                Some(false) => bad = middle,
                None => break,
            }
        }
    }
    if let Some(asked) = settings.asked.filter(|_| passes_by_itself) {
        measure(fault.what.with_severity(asked).severity(), &mut levels);
    }
    levels.sort_by(|a, b| a.severity.total_cmp(&b.severity));
    let tolerated = levels.iter().take_while(|level| settings.tolerates(level)).last();
    let tolerated = tolerated.map(|level| level.severity).filter(|severity| *severity > 0.0);
    Envelope {
        kind: info.name.to_owned(),
        target: fault.target.name().to_owned(),
        unit: info.parameters.first().map_or("", |first| first.unit).to_owned(),
        share: settings.share,
        is_all: levels.iter().all(|level| settings.tolerates(level)),
        levels,
        tolerated,
    }
}

/// Tenths of `least`, down to the limit of the kind.
fn below(what: FaultKind, least: f64) -> impl Iterator<Item = f64> {
    let floor = what.severity_range().0;
    let tenths = (1..=BELOW as i32).map(move |power| least * 0.1f64.powi(power));
    tenths.filter(move |severity| *severity >= floor)
}

fn at(
    executor: &impl Executor,
    fault: &Fault,
    severity: f64,
    settings: &EnvelopeSettings,
) -> Level {
    let fault = Fault { what: fault.what.with_severity(severity), ..fault.clone() };
    let job = |seed| {
        // Both directions of a kind that has them, in turns.
        let is_reversed = fault.what.is_signed() && seed % 2 == 1;
        let what = if is_reversed { fault.what.reversed() } else { fault.what };
        let struck = Fault { what, when: begin(&fault, seed, settings), ..fault.clone() };
        let faults = if severity > 0.0 { vec![struck] } else { Vec::new() };
        let result = executor.execute(&Case { seed, schedule: Schedule { faults } });
        Some(ended(&result, &settings.demanded))
    };
    let mut level =
        Level { severity, passed: 0, announced: 0, silent: 0, runs: 0, interval: (0.0, 1.0) };
    let mut runs = ROUND.min(settings.runs);
    loop {
        let first = settings.seed.saturating_add(level.runs);
        let last = settings.seed.saturating_add(runs);
        for (_, ended) in crate::seeds::for_each_seed(first..last, settings.threads, &job) {
            level.runs += 1;
            level.passed += u64::from(ended == Ended::Passed);
            level.announced += u64::from(settings.tells && ended == Ended::Announced);
            level.silent += u64::from(settings.tells && ended == Ended::Silent);
        }
        let interval =
            |z| wilson(level.passed, level.runs, z).map_or((0.0, 1.0), |of| (of.lower, of.upper));
        let (lower, upper) = interval(Z_ROUND);
        let is_decided = lower >= settings.share || upper < settings.share;
        if is_decided || runs == settings.runs || level.runs < runs {
            level.interval = interval(Z_95);
            return level;
        }
        runs = settings.runs.min(2 * runs);
    }
}

/// The start given by the fault. Otherwise it starts with the first motion after a bias test; a fault that would end at
/// once starts at a random time of the run, within a motion after the bias test if there is one.
fn begin(fault: &Fault, seed: u64, settings: &EnvelopeSettings) -> When {
    // Errors of a person can also occur before the test.
    if !fault.when.is_always() || fault.target == Target::Operator {
        return fault.when.clone();
    }
    if fault.what.info().lasts == Lasts::Scheduled {
        return match settings.motions.first() {
            Some((phase, _)) => When::Step { phase: phase.clone(), number: 1, after: Span::ZERO },
            None => When::Always,
        };
    }
    let mut random = RandomStream::new(seed, "envelope", "begin");
    let mut share = || 0.5 + 0.5 * random.symmetric_uniform();
    let motions: u32 = settings.motions.iter().map(|(_, times)| times).sum();
    let mut number = 1 + (share() * f64::from(motions)) as u32;
    for (phase, times) in &settings.motions {
        if number <= *times {
            let after = settings.course.within(phase, number, share());
            return When::Step { phase: phase.clone(), number, after };
        }
        number -= times;
    }
    let lasted_ms = settings.course.lasted.as_secs_f64() * 1e3;
    When::At(Span::from_millis((share() * lasted_ms) as i64))
}

/// Result of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Ended {
    Passed,
    Announced,
    Silent,
}

fn ended(result: &CaseResult, demanded: &BTreeSet<String>) -> Ended {
    let reached_all = demanded.is_subset(&result.reached);
    if result.passed && result.violated.is_empty() && reached_all {
        Ended::Passed
    } else if result.announced && !result.breaks(NO_SILENT_WRONG) {
        Ended::Announced
    } else {
        Ended::Silent
    }
}

/// The property that fails if a report comes too late.
const NO_SILENT_WRONG: &str = "no_silent_wrong";

#[cfg(test)]
mod tests;
