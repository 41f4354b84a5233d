//! Campaigns on the shipped robot: the same seed gives the same results on any number of threads; a finding is a plan
//! that anyone can run to reproduce it.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use campaign::{
    Campaign, Case, EnvelopeSettings, Executor as _, Guided, Journal, Regression, Settings, Space,
    envelope, run,
};
use harness::executors::Simulated;
use harness::operator::Answers;
use harness::run::Prepared;
use plan::Plan;
use plan::faults::{Fault, FaultKind, Schedule, Target, When};
use plan::made::Made;
use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::sync::Arc;
use wire::time::Span;

const PLAN: &str = include_str!("../../test-plans/live-side.toml");

fn prepared() -> Prepared {
    Prepared::load("live-side", &Made::default()).unwrap()
}

fn executor(prepared: Prepared) -> Simulated {
    Simulated::new(prepared, Answers::default())
}

fn campaign(cases: u64, threads: usize) -> Campaign {
    let prepared = prepared();
    let executor = executor(prepared.clone());
    let (horizon, clean) = executor.without_faults(1);
    assert!(clean.passed && clean.violated.is_empty(), "{clean:?}");
    let space = Space::new(&prepared.plan, prepared.rig.struck(), horizon, 4, &[]);
    let folder = tempfile::tempdir().unwrap();
    let mut journal = Journal::open(&folder.path().join("cases.jsonl"), "test").unwrap();
    let threads = NonZeroUsize::new(threads).unwrap();
    let settings = Settings { cases, threads, shrink_max: 200 };
    let mut search = Guided::new(&space, 1);
    run(&executor, &mut search, &BTreeMap::new(), &settings, &mut journal, &mut |_| true).unwrap()
}

#[test]
fn a_seed_gives_the_same_campaign_on_any_number_of_threads() {
    let one = campaign(48, 1);
    assert_eq!(one.tally.cases, 48);
    assert_eq!(one, campaign(48, 3));
}

/// A case that strikes the base two seconds into its straight line.
fn on_the_way(kind: &str, severity: f64) -> Case {
    let fault = Fault {
        when: When::Step {
            phase: plan::Name::new("straight").unwrap(),
            number: 1,
            after: Span::from_secs(2),
        },
        ..Fault::new(Target::Base, FaultKind::typical(kind).unwrap().with_severity(severity))
    };
    Case { seed: 3, schedule: Schedule { faults: vec![fault] } }
}

#[test]
fn the_smallest_case_is_a_plan_that_shows_the_same() {
    let simulated = executor(prepared());
    // Wheel slip: dead reckoning cannot detect it, and no other sensor reports it.
    let case = on_the_way("wheel_slip", 20.0);
    let result = simulated.execute(&case);
    assert!(result.breaks("no_silent_wrong"), "{result:?}");
    let shrunk = campaign::shrink(&simulated, &case, &result, "no_silent_wrong", 200);
    let mut violated = shrunk.result.violated.clone();
    violated.retain(|violated| violated.property == "no_silent_wrong");
    let regression = Regression {
        project: None,
        plan: "live-side",
        text: PLAN,
        property: "no_silent_wrong",
        what: &violated[0].what,
        case: &shrunk.case,
        small: shrunk.small(),
        again: Some(""),
    };
    let text = regression.to_toml(".".as_ref()).unwrap();
    let plan =
        Plan::parse("regression.toml", &text).unwrap_or_else(|error| panic!("{error:?}\n{text}"));
    let mut again = prepared();
    again.plan = Arc::new(plan);
    let mut replayed = executor(again).execute(&Case { seed: shrunk.case.seed, ..Case::default() });
    replayed.violated.retain(|violated| violated.property == "no_silent_wrong");
    assert_eq!(replayed.violated, violated);
}

/// The controller does not trust odometry that contradicts its commands.
#[test]
fn an_odometer_that_stands_still_is_told() {
    let simulated = executor(prepared());
    for severity in [0.5, 4.0] {
        let result = simulated.execute(&on_the_way("stuck_odometry", severity));
        assert!(result.violated.is_empty(), "{severity} s: {result:?}");
    }
}

/// The gyro was silent for less than its time-out, and continued from a plausible number: found by a campaign.
#[test]
fn a_gyro_that_starts_anew_in_a_turn_is_told() {
    let what = FaultKind::typical("restart").unwrap().with_severity(0.068_198_012_453_203_42);
    let fault =
        Fault { when: When::At(Span::from_millis(35_119)), ..Fault::new(Target::Gyro, what) };
    let case =
        Case { seed: 13_567_054_519_166_506_909, schedule: Schedule { faults: vec![fault] } };
    let result = executor(prepared()).execute(&case);
    assert!(result.violated.is_empty(), "{result:?}");
    assert!(result.reached.contains("samples_lost"), "{result:?}");
}

/// The warm lap of the campaigns on CAN, with the filter.
fn lap_with_the_filter() -> Simulated {
    let lap = include_str!("../../benchmarks/laps/lap.toml");
    let text = lap.replace("{ estimator = \"paper\" }", "{ estimator = \"kalman\" }");
    assert_ne!(text, lap);
    let devices = include_str!("../../benchmarks/laps/devices/warm-can.toml");
    let folder = tests::project::of([("lap.toml", &*text), ("devices/warm-can.toml", devices)]);
    let at = folder.path().join("lap.toml");
    executor(Prepared::load(&at.to_string_lossy(), &Made::default()).unwrap())
}

/// The gyro fell silent while the host stood still: what had waited was taken for new, and odometry bridged a silence
/// that had lasted for 17 s; or a single sample had waited for 40 s. Found by campaigns.
#[test]
fn a_host_that_stood_still_does_not_drive_by_what_waited() {
    let executor = lap_with_the_filter();
    let cases = [
        r#"{"seed": 17070579280651319955, "schedule": [
        {"target": "gyro", "what": {"disconnect": {"for_s": 1444.8345749131831}}, "when": {"at_s": 27.991}},
        {"target": "host", "what": {"scheduler_stall": {"for_s": 24.08057624855305}}, "when": {"during": "lap"}}]}"#,
        r#"{"seed": 1909849311801240084, "schedule": [
        {"target": "gyro", "what": {"restart": {"for_s": 398.48949352591217}}, "when": {"during": "lap"}},
        {"target": "host", "what": {"scheduler_stall": {"for_s": 39.84894935259121}}, "when": {"during": "lap"}}]}"#,
        r#"{"seed": 1909849311801240107, "schedule": [
        {"target": "gyro", "toward": "device", "what": {"repeat": {"repeat_percent": 73.48707093284118}}, "when": {"during": "bias_test"}},
        {"target": "host", "what": {"scheduler_stall": {"for_s": 44.0922425597047}}, "when": {"during": "lap"}},
        {"target": "gyro", "toward": "host", "what": {"disconnect": {"for_s": 2645.5345534822817}}, "when": {"during": "lap"}}]}"#,
    ];
    for case in cases {
        let result = executor.execute(&serde_json::from_str(case).unwrap());
        assert!(!result.breaks("fresh_heading"), "{case}: {result:?}");
    }
}

/// An order that had been held for 1.8 s turned the base by 6 deg while its pose was written: the turn was called done, and
/// the old pose was written again. Found by a campaign.
#[test]
fn a_base_that_moves_while_its_pose_is_written_is_brought_to_its_target_again() {
    let case = r#"{"seed": 1909849311801240085, "schedule": [
        {"target": "base", "toward": "host", "what": {"reorder": {"reorder_percent": 17.883042400175633}}, "when": {"during": "straight"}},
        {"target": "base", "toward": "device", "what": {"bit_errors": {"bit_error_rate": 0.017883042400175634}}, "when": {"during": "lap"}},
        {"target": "base", "what": {"delay": {"by_s": 1.7883042400175633}}, "when": {"step": "turn", "number": 3, "after_s": 4.109}, "duration_s": 0.064},
        {"target": "gyro", "toward": "host", "what": {"baud_drift": {"drift_percent": 2.682077988227698}}, "when": {"at_s": 31.157}, "duration_s": 0.077}]}"#;
    let result = lap_with_the_filter().execute(&serde_json::from_str(case).unwrap());
    assert!(result.violated.is_empty(), "{result:?}");
}

/// A short gap is bridged, a long one is not: the envelope is between.
#[test]
fn a_gyro_that_is_gone_for_long_is_not_tolerated_and_a_short_one_is() {
    let simulated = executor(prepared());
    let fault = Fault {
        when: When::At(Span::from_secs(25)),
        ..Fault::new(Target::Gyro, FaultKind::typical("disconnect").unwrap())
    };
    let settings = EnvelopeSettings {
        runs: 6,
        share: 0.5,
        asked: None,
        seed: 1,
        course: Span::from_secs(38).into(),
        motions: Vec::new(),
        demanded: <_>::default(),
        tells: true,
        threads: NonZeroUsize::new(2).unwrap(),
    };
    let found = envelope(&simulated, &fault, &settings, &mut |_| true);
    let at = |severity: f64| {
        let near = |level: &&campaign::Level| level.severity >= severity;
        found.levels.iter().find(near).unwrap()
    };
    assert_eq!(
        (at(10.0).passed, at(10.0).announced),
        (0, 6),
        "it gives up, and says so: {found:?}"
    );
    // After the gyro's time-out of 100 ms the mission is aborted.
    assert!(found.tolerated.is_none_or(|most| most < 1.0), "{found:?}");
}
