//! How much of one kind of fault is tolerated: the share of runs that pass over its severity.

use super::case::{Case, CaseResult};
use super::executor::Executor;
use super::space::severity;
use emulators::random::RandomStream;
use plan::confidence::{Z_95, wilson};
use plan::faults::{Fault, Lasts, Schedule, When};
use serde::{Deserialize, Serialize};
use std::num::NonZeroUsize;
use wire::time::Span;

/// How an envelope is measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnvelopeSettings {
    /// Runs at each severity, each with a seed of its own.
    pub runs: u64,
    /// What is tolerated passes in this share of runs at least, at 95 % confidence.
    pub share: f64,
    /// The first seed.
    pub seed: u64,
    /// A severity that is run whatever the rest shows: the one that is asked for.
    pub asked: Option<f64>,
    /// How long the plan takes where nothing goes wrong. A fault that lasts by itself, or an instant, begins at a
    /// time within it that is drawn from the seed of each run.
    pub horizon: Span,
    /// Runs at a time.
    pub threads: NonZeroUsize,
}

impl EnvelopeSettings {
    /// Runs that an envelope takes at most: those without a fault, the ladder, the halvings, and what is asked for.
    pub fn runs_max(&self) -> u64 {
        let levels = 1 + LADDER + HALVINGS + usize::from(self.asked.is_some());
        self.runs.saturating_mul(levels as u64)
    }
}

/// Runs that pass at one severity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Level {
    /// In the unit of the kind's first parameter; zero where there is no fault.
    pub severity: f64,
    /// Runs that passed.
    pub passed: u64,
    /// Runs.
    pub runs: u64,
    /// 95 % interval of the probability to pass (Wilson).
    pub interval: (f64, f64),
}

impl Level {
    /// Share of runs that passed.
    pub fn share(&self) -> f64 {
        if self.runs > 0 { self.passed as f64 / self.runs as f64 } else { 0.0 }
    }
}

/// The share of runs that pass over the severity of one kind.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Envelope {
    /// The kind.
    pub kind: String,
    /// What it strikes.
    pub target: String,
    /// Unit of severities.
    pub unit: String,
    /// Share of runs that has to pass.
    pub share: f64,
    /// What was run, the mildest first.
    pub levels: Vec<Level>,
    /// The greatest severity at which, and at every smaller one that was run, the lower end of the interval is
    /// `share` or more; none where even the least is not tolerated.
    pub tolerated: Option<f64>,
    /// The range ended there: more was not tried.
    pub is_all: bool,
}

impl Envelope {
    /// Runs that passed without any fault, where that is too few already.
    pub fn fails_by_itself(&self) -> Option<&Level> {
        let first = self.levels.first().filter(|level| level.severity == 0.0);
        first.filter(|level| level.interval.0 < self.share)
    }

    /// So much, and all less of it that was run, is tolerated.
    pub fn tolerates(&self, severity: f64) -> bool {
        self.tolerated.is_some_and(|most| most >= severity)
    }
}

/// One envelope, and what it should have been.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// The plan that ran.
    pub plan: String,
    /// What was measured.
    #[serde(flatten)]
    pub envelope: Envelope,
    /// The severity that must be tolerated, where one was asked for.
    pub at_least: Option<f64>,
}

impl Measured {
    /// What was asked for is tolerated; true where nothing was.
    pub fn holds(&self) -> bool {
        self.at_least.is_none_or(|least| self.envelope.tolerates(least))
    }
}

/// Severities of the first look, in even steps of the logarithm.
const LADDER: usize = 9;
/// Times that the step between what is tolerated and what is not is halved.
const HALVINGS: usize = 4;

impl EnvelopeSettings {
    /// Is a severity tolerated by what was run?
    fn tolerates(&self, level: &Level) -> bool {
        level.interval.0 >= self.share
    }
}

/// Measures the envelope of `fault` with one executor: no fault, a ladder over the whole range of its severity, then halves
/// between the last step that is tolerated and the next. `pulse` is told of each level; false stops.
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
    // Without any fault: what fails there says nothing of the fault.
    measure(0.0, &mut levels);
    let (mut good, mut bad) = (None, None);
    for step in 0..LADDER {
        match measure(rung(step), &mut levels) {
            Some(true) if bad.is_none() => good = Some(rung(step)),
            Some(false) if bad.is_none() => bad = Some(rung(step)),
            None => break,
            // What is worse shows how it goes on: it may pass again.
            Some(_) => {}
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
    if let Some(asked) = settings.asked {
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

fn at(
    executor: &impl Executor,
    fault: &Fault,
    severity: f64,
    settings: &EnvelopeSettings,
) -> Level {
    let fault = Fault { what: fault.what.with_severity(severity), ..fault.clone() };
    let seeds = settings.seed..settings.seed.saturating_add(settings.runs);
    let job = |seed| {
        let struck = Fault { when: begin(&fault, seed, settings.horizon), ..fault.clone() };
        let faults = if severity > 0.0 { vec![struck] } else { Vec::new() };
        let result = executor.execute(&Case { seed, schedule: Schedule { faults } });
        Some(is_good(&result))
    };
    let results = crate::seeds::for_each_seed(seeds, settings.threads, &job);
    let passed = results.iter().filter(|(_, good)| *good).count() as u64;
    let runs = results.len() as u64;
    let interval =
        wilson(passed, runs, Z_95).map_or((0.0, 1.0), |found| (found.lower, found.upper));
    Level { severity, passed, runs, interval }
}

/// As the fault says; where it says nothing and would be over at once, some time in the run.
fn begin(fault: &Fault, seed: u64, horizon: Span) -> When {
    if !fault.when.is_always() || fault.what.info().lasts == Lasts::Scheduled {
        return fault.when.clone();
    }
    let share = 0.5 + 0.5 * RandomStream::new(seed, "envelope", "begin").symmetric_uniform();
    When::At(Span::from_millis((1e3 * share * horizon.as_secs_f64()) as i64))
}

/// Its measurements are in their bands, and no property broke.
fn is_good(result: &CaseResult) -> bool {
    result.passed && result.violated.is_empty()
}

#[cfg(test)]
mod tests {
    use super::begin;
    use super::{EnvelopeSettings, envelope};
    use crate::{Case, CaseResult, Executor};
    use emulators::random::RandomStream;
    use plan::faults::{Fault, FaultKind, Target, When};
    use std::collections::BTreeSet;
    use std::num::NonZeroUsize;
    use wire::time::Span;

    /// Passes for certain up to 2 %, and then ever less often: half of the runs at 4 %.
    struct Slope;

    impl Executor for Slope {
        fn execute(&self, case: &Case) -> CaseResult {
            let severity = case.schedule.faults.first().map_or(0.0, |fault| fault.what.severity());
            let mut chance = RandomStream::new(case.seed, "slope", "pass");
            let passes = chance.symmetric_uniform() < 1.0 - (severity - 2.0).max(0.0) / 2.0;
            CaseResult { passed: passes, ..CaseResult::default() }
        }
    }

    const SETTINGS: EnvelopeSettings = EnvelopeSettings {
        runs: 200,
        asked: None,
        share: 0.9,
        seed: 1,
        horizon: Span::from_secs(10),
        threads: NonZeroUsize::new(2).unwrap(),
    };

    #[test]
    fn what_is_tolerated_lies_where_the_share_says() {
        let fault = Fault::new(Target::Gyro, FaultKind::typical("drop").unwrap());
        let found = envelope(&Slope, &fault, &SETTINGS, &mut |_| true);
        let tolerated = found.tolerated.unwrap();
        // 90 % pass at 2.4 %; so many runs tell it from 95 %, which is at 2.2 %.
        assert!((1.8..2.4).contains(&tolerated), "{found:?}");
        assert!(!found.is_all);
        assert!(found.levels.windows(2).all(|pair| pair[0].severity < pair[1].severity));
        assert_eq!(found.unit, "%");
    }

    #[test]
    fn what_is_never_tolerated_and_what_always_is_are_told() {
        struct Only(bool);
        impl Executor for Only {
            fn execute(&self, _: &Case) -> CaseResult {
                CaseResult { passed: self.0, ..CaseResult::default() }
            }
        }
        let fault = Fault::new(Target::Gyro, FaultKind::typical("drop").unwrap());
        let never = envelope(&Only(false), &fault, &SETTINGS, &mut |_| true);
        assert_eq!((never.tolerated, never.is_all), (None, false));
        let always = envelope(&Only(true), &fault, &SETTINGS, &mut |_| true);
        assert_eq!((always.tolerated, always.is_all), (Some(100.0), true));
    }

    #[test]
    fn what_is_asked_for_is_run() {
        let fault = Fault::new(Target::Gyro, FaultKind::typical("drop").unwrap());
        let settings = EnvelopeSettings { asked: Some(1.234), ..SETTINGS };
        let found = envelope(&Slope, &fault, &settings, &mut |_| true);
        assert!(found.levels.iter().any(|level| level.severity == 1.234));
        assert!(found.tolerates(1.234) && !found.tolerates(4.0));
    }

    #[test]
    fn what_is_over_at_once_begins_at_some_time_by_the_seed() {
        let horizon = Span::from_secs(10);
        let of = |name: &str| Fault::new(Target::Gyro, FaultKind::typical(name).unwrap());
        let drawn: BTreeSet<i64> = (0..50)
            .map(|seed| match begin(&of("disconnect"), seed, horizon) {
                When::At(at) if at < horizon => at.as_nanos(),
                other => panic!("{other:?}"),
            })
            .collect();
        assert!(drawn.len() > 40);
        assert_eq!(begin(&of("drop"), 1, horizon), When::Always);
        let told = Fault { when: When::At(horizon), ..of("disconnect") };
        assert_eq!(begin(&told, 1, horizon), told.when);
    }
}
