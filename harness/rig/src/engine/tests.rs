//! What the engine makes of a controller that does not keep to its part.

use super::robot::{MOVES_ON, NO_REST};
use super::{Action, BenchFacts, Engine};
use controller::health::{Causes, Health};
use controller::mission::{Activity, MissionResult, Report, State};
use plan::Plan;
use record::RecordKind;
use record::outcome::Outcome;
use std::collections::BTreeMap;
use std::sync::Arc;
use wire::time::{Span, Timestamp};
use wire::units::{Angle, AngularRate, Length, Pose};

fn state(moving: bool) -> State {
    State {
        activity: Activity::Idle,
        pose: Pose::default(),
        gyro_heading: Angle::ZERO,
        odometry_heading: Angle::ZERO,
        displacement: Length::ZERO,
        heading_error: None,
        raw_rate: AngularRate::from_deg_per_s(0.5),
        bias: AngularRate::ZERO,
        temperature: None,
        moving,
        samples: 0,
        samples_lost: 0,
        clock_ratio: None,
        health: Health::default(),
        uncertainty: None,
    }
}

fn at(millis: i64) -> Timestamp {
    Timestamp::ZERO + Span::from_millis(millis)
}

/// An engine with a controller, whose plan has these steps and judges this quantity.
fn engine(steps: &str, quantity: &str, unit: &str) -> Engine {
    let text = format!(
        "name = \"still\"\ntitle = \"Nothing moves\"\ndevices = \"paper\"\nsteps = [{steps}]\n\
         [[measurement]]\nname = \"judged\"\ndoc = \"Judged\"\nquantity = \"{quantity}\"\n\
         unit = \"{unit}\"\ncheck = {{ all_within = [0, 0] }}\n"
    );
    let plan = Arc::new(Plan::parse("still.toml", &text).expect("a plan"));
    Engine::new(plan, Timestamp::ZERO).with_robot(BenchFacts::default(), BTreeMap::new())
}

/// The missions and notes so far.
fn did(engine: &mut Engine) -> (usize, Vec<String>) {
    let (mut missions, mut notes) = (0, Vec::new());
    while let Some(action) = engine.action() {
        match action {
            Action::Mission(_) => missions += 1,
            Action::Record(_, RecordKind::Note(note)) => notes.push(note),
            _ => {}
        }
    }
    (missions, notes)
}

const WAIT: &str = "{ wait = { duration_s = 1 } }";

/// What a controller says of itself is judged: it was told to stop.
#[test]
fn a_controller_that_moves_on_after_the_stop_has_failed() {
    let ended = |moving: bool, says_until: i64| {
        let mut engine = engine(WAIT, "health.degraded", "1");
        engine.report(at(0), &Report::State(state(false)));
        for now in (1_000..=6_000).step_by(100) {
            if now < says_until {
                engine.report(at(now), &Report::State(state(moving)));
            }
            engine.wake(at(now));
        }
        let ending = engine.ending().expect("it is over").clone();
        (ending.outcome, ending.reason)
    };
    assert_eq!(ended(false, 6_000), (Outcome::Passed, None));
    assert_eq!(ended(true, 6_000), (Outcome::Failed, Some(MOVES_ON.to_owned())));
    assert_eq!(ended(true, 3_000), (Outcome::Failed, Some(NO_REST.to_owned())), "it fell silent");
}

#[test]
fn a_second_answer_and_one_to_no_mission_are_noted_and_the_last_is_in_the_reason() {
    let test = "{ bias_test = { duration_s = 20 } }";
    let mut engine = engine(&format!("{{ bias_method = \"none\" }}, {test}"), "bias.mean", "deg/s");
    engine.report(at(0), &Report::State(state(false)));
    let done = |id| Report::Done { id, result: MissionResult::Applied };
    engine.report(at(10), &done(1));
    assert_eq!(did(&mut engine), (2, Vec::new()));
    engine.report(at(20), &done(1));
    engine.report(at(30), &done(99));
    let notes = ["mission 1, once more", "mission 99, which was not given"]
        .map(|what| format!("the controller answered {what}"));
    assert_eq!(did(&mut engine), (0, notes.to_vec()));
    engine.wake(at(31_000));
    engine.wake(at(37_000));
    let reason = engine.ending().and_then(|ending| ending.reason.clone()).unwrap_or_default();
    assert!(
        reason.contains("took longer than its limit; the controller answered mission 99"),
        "{reason}"
    );
}

/// The last question is answered by a state, which ends the run, and then as a mission.
#[test]
fn what_comes_after_the_end_is_no_second_answer() {
    let mut engine = engine(WAIT, "health.degraded", "1");
    engine.report(at(0), &Report::State(state(false)));
    engine.wake(at(1_000));
    engine.wake(at(1_200));
    engine.report(at(1_210), &Report::State(state(false)));
    assert_eq!(engine.ending().map(|ending| ending.outcome), Some(Outcome::Passed));
    engine.report(at(1_220), &Report::Done { id: 2, result: MissionResult::Applied });
    assert_eq!(did(&mut engine), (2, Vec::new()));
}

/// A controller that has just started says that its base moves until it has heard from it.
#[test]
fn the_first_mission_waits_for_rest_and_not_for_ever() {
    let begun = || {
        let mut engine = engine("{ bias_test = { duration_s = 20 } }", "bias.mean", "deg/s");
        engine.report(at(0), &Report::State(state(true)));
        assert_eq!(did(&mut engine).0, 0);
        engine
    };
    let mut engine = begun();
    engine.report(at(300), &Report::State(state(false)));
    assert_eq!(did(&mut engine).0, 1);
    let mut engine = begun();
    assert_eq!(engine.next_wakeup(), at(5_000));
    engine.report(at(4_000), &Report::State(state(true)));
    assert_eq!(did(&mut engine).0, 0);
    engine.wake(at(5_000));
    assert_eq!(did(&mut engine).0, 1, "it is the controller's to refuse");
}

/// States once a second; the gyro's last sample comes at `gone`.
fn logged(gone: i64, back: i64) -> (Vec<f64>, Option<String>) {
    let mut engine = engine("{ log = { duration_s = 10, interval_s = 1 } }", "gyro.rate", "deg/s");
    let mut samples = 0;
    for now in (0..=10_000).step_by(100) {
        let silent = now > gone && now < back;
        samples += if silent { 0 } else { 10 };
        if now % 1_000 == 0 {
            let causes = Causes { gyro_silent: silent, ..Causes::default() };
            let health = Health::new(false, causes);
            engine.report(at(now), &Report::State(State { samples, health, ..state(false) }));
        }
        engine.wake(at(now));
    }
    let times = engine.observations().of("gyro.rate").filter_map(|one| one.time()).collect();
    for now in [10_200, 10_400] {
        engine.report(at(now), &Report::State(state(false)));
        engine.wake(at(now));
    }
    (times, engine.ending().expect("it is over").reason.clone())
}

#[test]
fn a_log_keeps_no_rate_of_a_gyro_that_is_silent() {
    let seconds = |from: i32, to: i32| (from..=to).map(f64::from).collect::<Vec<_>>();
    assert_eq!(logged(99_000, 0), (seconds(1, 10), None));
    let (times, reason) = logged(4_500, 7_500);
    assert_eq!((times, reason), ([seconds(1, 4), seconds(8, 10)].concat(), None));
    let (times, reason) = logged(4_500, 99_000);
    assert_eq!(times, seconds(1, 4));
    assert!(reason.unwrap_or_default().ends_with("the gyro was silent at its end"));
}

#[test]
fn samples_that_health_calls_lost_are_counted_as_one_at_least() {
    let lost = |says: bool, counted: u64| {
        let mut engine = engine(WAIT, "samples.lost", "1");
        engine.report(at(0), &Report::State(state(false)));
        let causes = Causes { samples_lost: says, ..Causes::default() };
        engine.report(at(10), &Report::Health(Health::new(false, causes)));
        engine.report(at(20), &Report::State(State { samples_lost: counted, ..state(false) }));
        engine.wake(at(1_000));
        engine.observations().of("samples.lost").map(|one| one.value()).collect::<Vec<_>>()
    };
    assert_eq!(lost(false, 0), [0.0]);
    assert_eq!(lost(true, 0), [1.0]);
    assert_eq!(lost(true, 7), [7.0]);
}
