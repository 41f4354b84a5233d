use super::{EnvelopeSettings, ROUND, begin, envelope};
use crate::case::Violated;
use crate::{Case, CaseResult, Course, Executor};
use emulators::random::RandomStream;
use plan::Name;
use plan::faults::{Fault, FaultKind, Target, When};
use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use wire::time::Span;

/// Always passes up to 2 %, then less and less often: half of the runs at 4 %.
struct Slope;

impl Executor for Slope {
    fn execute(&self, case: &Case) -> CaseResult {
        let severity = case.schedule.faults.first().map_or(0.0, |fault| fault.what.severity());
        let mut chance = RandomStream::new(case.seed, "slope", "pass");
        let passes = chance.symmetric_uniform() < 1.0 - (severity - 2.0).max(0.0) / 2.0;
        CaseResult { passed: passes, ..CaseResult::default() }
    }
}

/// Runs end as this function of the severity.
struct By(fn(f64) -> CaseResult);

impl Executor for By {
    fn execute(&self, case: &Case) -> CaseResult {
        (self.0)(case.schedule.faults.first().map_or(0.0, |fault| fault.what.severity()))
    }
}

fn settings() -> EnvelopeSettings {
    EnvelopeSettings {
        runs: 200,
        asked: None,
        share: 0.9,
        seed: 1,
        course: Span::from_secs(10).into(),
        motions: Vec::new(),
        demanded: BTreeSet::new(),
        tells: true,
        threads: NonZeroUsize::new(2).unwrap(),
    }
}

fn of(name: &str) -> Fault {
    Fault::new(Target::Gyro, FaultKind::typical(name).unwrap())
}

#[test]
fn what_is_tolerated_lies_where_the_share_says() {
    let found = envelope(&Slope, &of("drop"), &settings(), &mut |_| true);
    let tolerated = found.tolerated.unwrap();
    // 90 % pass at 2.4 %; this many runs distinguish it from 95 %, which is at 2.2 %.
    assert!((1.8..2.4).contains(&tolerated), "{found:?}");
    assert!(!found.is_all);
    assert!(found.levels.windows(2).all(|pair| pair[0].severity < pair[1].severity));
    assert_eq!(found.unit, "%");
    // Clear cases take one round, close ones the maximum.
    let runs: BTreeSet<u64> = found.levels.iter().map(|level| level.runs).collect();
    assert!(runs.contains(&ROUND) && runs.contains(&200), "{runs:?}");
}

#[test]
fn what_is_never_tolerated_and_what_always_is_are_told() {
    let never = By(|_| CaseResult::default());
    let never = envelope(&never, &of("drop"), &settings(), &mut |_| true);
    assert_eq!((never.tolerated, never.is_all), (None, false));
    assert!(never.fails_by_itself().is_some() && never.levels.len() == 1, "{never:?}");
    let always = By(|_| CaseResult { passed: true, ..CaseResult::default() });
    let always = envelope(&always, &of("drop"), &settings(), &mut |_| true);
    assert_eq!((always.tolerated, always.is_all), (Some(100.0), true));
}

/// Found by a user: a state that no run reached counted as passed at every severity.
#[test]
fn a_run_that_does_not_reach_what_the_plan_demands_fails() {
    let doses = |severity: f64| {
        let reached = (severity < 10.0).then(|| "doses".to_owned());
        CaseResult { passed: true, reached: reached.into_iter().collect(), ..CaseResult::default() }
    };
    let demanding = |state: &str| EnvelopeSettings {
        demanded: BTreeSet::from([state.to_owned()]),
        asked: Some(50.0),
        ..settings()
    };
    let found = envelope(&By(doses), &of("drop"), &demanding("doses"), &mut |_| true);
    assert!(found.tolerates(5.0) && !found.tolerates(50.0), "{found:?}");
    let found = envelope(&By(doses), &of("drop"), &demanding("empties"), &mut |_| true);
    assert!(found.fails_by_itself().is_some(), "{found:?}");
}

#[test]
fn below_the_ladder_it_goes_on_in_tenths() {
    let least = By(|severity| CaseResult { passed: severity < 3e-4, ..CaseResult::default() });
    let found = envelope(&least, &of("drop"), &settings(), &mut |_| true);
    let tolerated = found.tolerated.unwrap();
    assert!((2.5e-4..3e-4).contains(&tolerated), "{found:?}");
}

#[test]
fn what_fails_in_silence_is_told_from_what_says_so() {
    let ends = By(|severity| {
        let late = Violated { property: "no_silent_wrong".into(), at_s: 1.0, what: String::new() };
        CaseResult {
            passed: severity < 1.0,
            announced: severity < 20.0,
            // It is reported, but too late.
            violated: if (5.0..20.0).contains(&severity) { vec![late] } else { Vec::new() },
            ..CaseResult::default()
        }
    });
    let found = envelope(&ends, &of("drop"), &settings(), &mut |_| true);
    for level in &found.levels {
        let expected = match level.severity {
            severity if severity < 1.0 => (level.runs, 0, 0),
            severity if severity < 5.0 => (0, level.runs, 0),
            _ => (0, 0, level.runs),
        };
        assert_eq!((level.passed, level.announced, level.silent), expected, "{level:?}");
    }
    assert!(found.most_silent().is_some_and(|level| level.severity >= 5.0));
    let nobody = EnvelopeSettings { tells: false, ..settings() };
    let found = envelope(&ends, &of("drop"), &nobody, &mut |_| true);
    assert!(!found.tells());
}

#[test]
fn what_is_asked_for_is_run() {
    let settings = EnvelopeSettings { asked: Some(1.234), ..settings() };
    let found = envelope(&Slope, &of("drop"), &settings, &mut |_| true);
    assert!(found.levels.iter().any(|level| level.severity == 1.234));
    assert!(found.tolerates(1.234) && !found.tolerates(4.0));
}

#[test]
fn what_is_over_at_once_begins_at_some_time_by_the_seed() {
    let settings = settings();
    let drawn: BTreeSet<i64> = (0..50)
        .map(|seed| match begin(&of("disconnect"), seed, &settings) {
            When::At(at) if at < settings.course.lasted => at.as_nanos(),
            other => panic!("{other:?}"),
        })
        .collect();
    assert!(drawn.len() > 40);
    assert_eq!(begin(&of("drop"), 1, &settings), When::Always);
    let told = Fault { when: When::At(settings.course.lasted), ..of("disconnect") };
    assert_eq!(begin(&told, 1, &settings), told.when);
}

#[test]
fn after_a_bias_test_faults_strike_the_motions() {
    let name = |name| Name::new(name).unwrap();
    let motions = vec![(name("straight"), 4), (name("turn"), 4)];
    let lengths = |name: &str| match name {
        "turn" => vec![Span::from_secs(3); 4],
        _ => vec![Span::from_secs(8); 4],
    };
    let phases = ["straight", "turn"].map(|name| (name.to_owned(), lengths(name))).into();
    let course = Course { lasted: Span::from_secs(50), phases };
    let settings = EnvelopeSettings { motions, course: course.clone(), ..settings() };
    let first = When::Step { phase: name("straight"), number: 1, after: Span::ZERO };
    assert_eq!(begin(&of("drop"), 1, &settings), first);
    let drawn: BTreeSet<String> = (0..200)
        .map(|seed| match begin(&of("disconnect"), seed, &settings) {
            When::Step { phase, number, after } => {
                assert!(
                    after < course.length(&phase, number),
                    "{phase:?} has ended after {after:?}"
                );
                format!("{} {number}", phase.as_str())
            }
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(drawn.len(), 8, "{drawn:?}");
}
