//! The ends of a plan's runs, each of which leaves the bench at rest.

use controller::calibration::Factor;
use emulators::base::Transport;
use emulators::device_file::Devices;
use harness::operator::Answers;
use harness::run::simulate;
use record::outcome::Outcome;
use record::sink::{Level, MemorySink};
use record::{Device, RecordKind};
use tests::devices::{NAVIGATOR, TRANSPORTS, ideal, ideal_table};
use tests::plans::{Run, plan_measuring, plan_of, prepared, run, run_with};
use wire::time::Timestamp;

fn robot(steps: &str) -> Run {
    run(&prepared(&plan_of(steps), ideal(Transport::Can)), 1)
}

fn table(steps: &str) -> Run {
    run(&prepared(&plan_of(steps), ideal_table(NAVIGATOR)), 1)
}

/// Checks the outcome, and that the reason contains all of these words.
fn assert_ended(run: &Run, outcome: Outcome, words: &[&str]) {
    let ending = &run.simulated.ending;
    assert_eq!(ending.outcome, outcome, "{ending:?}");
    let reason = ending.reason.as_deref().unwrap_or_default();
    for word in words {
        assert!(reason.contains(word), "\"{word}\" is not in \"{reason}\"");
    }
    run.assert_at_rest();
}

const READY: &str = "{ bias_test = { duration_s = 1 } },";

fn after_ready(steps: &str) -> String {
    format!("{READY} {steps}")
}

#[test]
fn a_plan_that_is_done_has_passed() {
    for steps in ["{ wait = { duration_s = 1 } }", "{ turn = { angle_deg = 90 } }"] {
        let run = robot(&after_ready(steps));
        assert_ended(&run, Outcome::Passed, &[]);
        assert_eq!(run.simulated.ending.reason, None);
    }
}

#[test]
fn a_step_that_takes_too_long_stops_the_base() {
    for transport in TRANSPORTS {
        for step in [
            "{ straight = { distance_m = 4 }, time_limit_s = 3 }",
            "{ turn = { angle_deg = 360 }, time_limit_s = 3 }",
        ] {
            let run = run(&prepared(&plan_of(&after_ready(step)), ideal(transport)), 1);
            let words = ["steps[1]", "took longer than its limit"];
            assert_ended(&run, Outcome::Timeout, &words);
            // One second until all inputs are received, one of bias test, three of the step, and braking.
            assert!(run.simulated.end < Timestamp::from_secs_f64(8.0), "{:?}", run.simulated.end);
        }
    }
}

#[test]
fn a_turn_of_the_table_that_takes_too_long_stops_the_table() {
    let run = table(&after_ready("{ table_turn = { angle_deg = 3600 }, time_limit_s = 5 }"));
    assert_ended(&run, Outcome::Timeout, &["steps[1]", "took longer than its limit"]);
}

#[test]
fn a_plan_that_takes_too_long_is_ended_as_a_whole() {
    let text = plan_of(&after_ready("{ straight = { distance_m = 4 } }"))
        .replace("devices = ", "time_limit_s = 4\ndevices = ");
    let run = run(&prepared(&text, ideal(Transport::Can)), 1);
    assert_ended(&run, Outcome::Timeout, &["the plan took longer than its limit"]);
}

#[test]
fn a_repeat_that_takes_too_long_is_ended_within_a_step() {
    let run = robot(&after_ready(
        "{ repeat = { times = 9, steps = [{ wait = { duration_s = 2 } }] }, time_limit_s = 5 }",
    ));
    assert_ended(&run, Outcome::Timeout, &["steps[1].repeat[0] (round 3 of 9)"]);
}

#[test]
fn what_the_controller_refuses_fails_the_run_at_that_step() {
    let run = robot("{ wait = { duration_s = 1 } }, { turn = { angle_deg = 90 } }");
    assert_ended(&run, Outcome::Failed, &["steps[1]", "the controller refused", "no bias"]);
    let run = robot(&after_ready("{ straight = { distance_m = 1, speed_m_per_s = 2 } }"));
    assert_ended(&run, Outcome::Failed, &["steps[1]", "out of range"]);
}

#[test]
fn what_the_controller_breaks_off_fails_the_run_at_that_step() {
    let mut devices = ideal(Transport::Can);
    devices.gyro.1.range_deg_per_s = 20.0;
    let run = run(&prepared(&plan_of(&after_ready("{ turn = { angle_deg = 360 } }")), devices), 1);
    assert_ended(&run, Outcome::Failed, &["steps[1]", "the controller broke off", "gyro fault"]);
}

#[test]
fn observations_carry_the_sweep_and_the_repetition_they_are_from() {
    let steps = r#"{ sweep = { parameter = "gyro.bias_deg_per_h", values = [0, 360], steps = [
        { repeat = { times = 2, steps = [
            { bias_test = { duration_s = 1 }, label = "inner" },
        ] }, label = "outer" },
    ] } }"#;
    let text = plan_measuring(steps, "bias.mean", "deg/s");
    let run = run(&prepared(&text, ideal(Transport::Can)), 1);
    assert_ended(&run, Outcome::Passed, &[]);
    let seen: Vec<_> = run
        .simulated
        .observations
        .iter()
        .map(|o| (o.tags["gyro.bias_deg_per_h"], o.tags["run"], o.value))
        .collect();
    let found: Vec<_> = seen.iter().map(|(swept, run, _)| (*swept, *run)).collect();
    assert_eq!(found, [(0.0, 1.0), (0.0, 2.0), (360.0, 3.0), (360.0, 4.0)]);
    for (swept, _, bias) in seen {
        // Within half a step of the wire's rate, 0.0031 deg/s.
        assert!((bias - swept / 3_600.0).abs() < 0.0016, "{bias} at {swept}");
    }
    for observation in run.simulated.observations.iter() {
        for phase in ["sweep", "repeat", "bias_test", "inner", "outer"] {
            assert!(observation.tags.contains_key(&format!("during.{phase}")), "{phase}");
        }
        assert!(!observation.tags.contains_key("during.turn"));
    }
}

/// A gyro that warms up from 20 to 40 degC within minutes.
fn warming() -> Devices {
    let mut devices = ideal_table(NAVIGATOR);
    devices.gyro.1.self_heating_kelvin = 20.0;
    devices.gyro.1.thermal_time_constant_s = 60.0;
    devices
}

#[test]
fn a_repeat_ends_when_its_condition_holds() {
    let steps = r#"{ repeat = { times = 1000, until = { above = { quantity = "gyro.temperature", limit = 30 } }, steps = [
        { bias_test = { duration_s = 5 } },
    ] } }"#;
    let run = run(&prepared(&plan_measuring(steps, "bias.mean", "deg/s"), warming()), 1);
    assert_ended(&run, Outcome::Passed, &[]);
    // Half of the way takes 60 s ln 2 = 41.6 s: the ninth test of 5 s is the last.
    assert_eq!(run.observed("bias.mean").len(), 9);
}

#[test]
fn a_repeat_whose_condition_holds_already_is_passed_over() {
    let steps = r#"
        { wait_until = { above = { quantity = "gyro.temperature", limit = 30, for_s = 10 } } },
        { repeat = { times = 9, until = { above = { quantity = "gyro.temperature", limit = 30 } }, steps = [
            { bias_test = { duration_s = 5 } },
        ] } },
        { wait = { duration_s = 1 } },
    "#;
    let run = run(&prepared(&plan_measuring(steps, "bias.mean", "deg/s"), warming()), 1);
    assert_ended(&run, Outcome::Passed, &[]);
    assert!(run.observed("bias.mean").is_empty());
    let end_s = run.simulated.end.as_secs_f64();
    // Warm enough after 41.6 s; averages and states of 1 s, 10 s of holding, 1 s of waiting.
    assert!((52.6..56.0).contains(&end_s), "{end_s}");
}

#[test]
fn repetitions_keep_their_period_and_tell_when_they_cannot() {
    let steps = |seconds: u32| {
        format!(
            "{{ repeat = {{ times = 3, period_s = 10, steps = [{{ wait = {{ duration_s = {seconds} }} }}] }} }}"
        )
    };
    let overruns = |seconds| {
        let text = plan_measuring(&steps(seconds), "repeat.overrun", "s");
        let run = run(&prepared(&text, ideal(Transport::Can)), 1);
        assert_ended(&run, Outcome::Passed, &[]);
        run.observed("repeat.overrun")
    };
    assert_eq!(overruns(4), [0.0, 0.0]);
    assert_eq!(overruns(12), [2.0, 2.0]);
}

const PROMPT: &str = r#"{ operator_prompt = { text = "How warm is the room?",
    answer = { name = "room", unit = "degC", range = [5, 40] } } }"#;

#[test]
fn a_question_needs_an_answer_that_can_be() {
    let text = plan_measuring(PROMPT, "operator.room", "degC");
    let prepared = prepared(&text, ideal(Transport::Can));
    let answered = |value: Option<f64>| {
        let answers = value.map(|value| ("room".to_owned(), value)).into_iter().collect();
        run_with(&prepared, 1, &answers)
    };
    let run = answered(Some(21.5));
    assert_ended(&run, Outcome::Passed, &[]);
    assert_eq!(run.observed("operator.room"), [21.5]);
    assert_ended(&answered(None), Outcome::Error, &["no answer \"room\" was given"]);
    assert_ended(&answered(Some(70.0)), Outcome::Error, &["room = 70", "not in"]);
    assert_ended(&answered(Some(f64::NAN)), Outcome::Error, &["room = NaN", "not in"]);
}

#[test]
fn a_prompt_that_asks_for_nothing_is_done() {
    let run = robot("{ operator_prompt = { text = \"Clear the floor.\" } }");
    assert_ended(&run, Outcome::Passed, &[]);
}

#[test]
fn a_parameter_that_does_not_exist_or_may_not_be_so_is_an_error() {
    let set = |parameter: &str, value: f64| {
        robot(&format!("{{ set_parameter = {{ parameter = \"{parameter}\", value = {value} }} }}"))
    };
    assert_ended(&set("gyro.bias_deg_per_h", 10.0), Outcome::Passed, &[]);
    let words = ["gyro.bias_deg_per_hour", "no parameter", "bias_deg_per_h`?"];
    assert_ended(&set("gyro.bias_deg_per_hour", 10.0), Outcome::Error, &words);
    assert_ended(&set("gyro.bandwidth_hz", -1.0), Outcome::Error, &["gyro.bandwidth_hz"]);
    assert_ended(&set("table.step_deg", 1.0), Outcome::Error, &["no device \"table\""]);
    assert_ended(&set("room.light", 1.0), Outcome::Error, &["no device \"room\""]);
}

#[test]
fn a_parameter_counts_from_then_on() {
    let steps = r#"
        { bias_test = { duration_s = 1 } },
        { set_parameter = { parameter = "gyro.bias_deg_per_h", value = 720 } },
        { wait = { duration_s = 1 } },
        { bias_test = { duration_s = 1 } },
    "#;
    let run =
        run(&prepared(&plan_measuring(steps, "bias.mean", "deg/s"), ideal(Transport::Can)), 1);
    let [before, after] = run.observed("bias.mean")[..] else { panic!("two tests") };
    assert!(before == 0.0 && (after - 0.2).abs() < 0.0016, "{before} {after}");
}

#[test]
fn a_calibration_that_nobody_made_is_an_error() {
    let run = table("{ use_calibration = \"no-such\" }");
    assert_ended(&run, Outcome::Error, &["steps[0]", "no calibration \"no-such\""]);
}

#[test]
fn a_run_that_somebody_stops_is_aborted_with_the_base_at_rest() {
    let text = plan_of(&after_ready("{ straight = { distance_m = 400 } }"));
    let prepared = prepared(&text, ideal(Transport::Can));
    let mut sink = MemorySink::new(Level::Full);
    let mut asked = 0;
    let simulated = simulate(&prepared, 1, &Answers::default(), &mut sink, &mut |progress| {
        asked += 1;
        // Not at the start, but at the first check during the run.
        progress.now == Timestamp::ZERO
    });
    assert_eq!(asked, 2);
    let run = Run { simulated, records: sink.into_records() };
    assert_ended(&run, Outcome::Aborted, &["stopped by request"]);
    let far = run
        .records
        .iter()
        .any(|record| matches!(record.kind, RecordKind::Truth { pose, .. } if pose.x.m() > 1.0));
    assert!(far, "it was stopped in motion");
}

#[test]
fn a_fit_becomes_a_calibration_that_is_used() {
    const SCALE_ERROR: f64 = 0.01;
    let turns = "{ table_turn = { angle_deg = -360 } }, { table_turn = { angle_deg = 360 } }";
    for (model, factors) in [("mean", 1), ("by_direction", 1)] {
        let steps = format!(
            r#"{READY} {turns},
            {{ fit = {{ name = "error", quantity = "table.error", model = "{model}" }} }},
            {{ save_calibration = {{ name = "fresh", from = ["error"] }} }},
            {{ use_calibration = "fresh" }},
            {turns},
            {{ use_calibration = "none" }},
            {turns}"#
        );
        let mut devices = ideal_table(NAVIGATOR);
        devices.gyro.1.scale_ppm = SCALE_ERROR * 1e6;
        let run = run(&prepared(&plan_measuring(&steps, "table.error", "deg"), devices), 1);
        assert_ended(&run, Outcome::Passed, &[]);
        let errors = run.observed("table.error");
        assert_eq!(errors.len(), 6);
        for (index, error) in errors.iter().enumerate() {
            let expected = if [2, 3].contains(&index) { 0.0 } else { 360.0 * SCALE_ERROR };
            // Half a step of the wire's rate, always with the same sign, for 14 s; each turn has its own.
            assert!((error - expected).abs() < 2.0 * 14.0 * 0.0016, "turn {index}: {error}");
        }
        let made = &run.simulated.made.calibrations["fresh"];
        assert_eq!(made.factors.len(), factors);
        match made.factors[0] {
            Factor::Constant(factor) => {
                assert!((factor * (1.0 + SCALE_ERROR) - 1.0).abs() < 1e-4, "{factor}");
            }
            Factor::Direction { cw_error_deg, ccw_error_deg } => {
                assert!((cw_error_deg - 3.6).abs() < 0.03 && (ccw_error_deg - 3.6).abs() < 0.03);
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_fit_of_nothing_fails() {
    let run = table(
        r#"{ fit = { name = "error", quantity = "table.error", model = "mean" } },
        { save_calibration = { name = "fresh", from = ["error"] } }"#,
    );
    assert_ended(&run, Outcome::Failed, &["steps[0]", "nothing to fit"]);
    assert!(run.simulated.made.is_empty());
}

#[test]
fn what_a_bench_does_not_have_is_an_error() {
    let place = "{ place = { x_m = 0, y_m = 0, heading_deg = 0 } }";
    assert_ended(&table(place), Outcome::Error, &["no robot that could be carried"]);
    assert_ended(&table("{ measure_pose = \"start\" }"), Outcome::Error, &["no base"]);
    let lap = after_ready("{ lap = { direction = \"cw\" } }");
    assert_ended(&table(&lap), Outcome::Error, &["no base"]);
    let cycle = "{ power_cycle = { device = \"gyro\", off_s = 60 } }";
    let words = ["cannot switch the power of \"gyro\""];
    assert_ended(&robot(cycle), Outcome::Error, &words);
}

#[test]
fn a_table_turn_without_a_table_does_not_end_well() {
    let run = robot("{ table_turn = { angle_deg = 360 } }");
    assert_ne!(run.simulated.ending.outcome, Outcome::Passed);
    run.assert_at_rest();
}

#[test]
fn every_step_that_began_before_the_end_is_in_the_record_in_order() {
    let run = robot(&after_ready(
        "{ repeat = { times = 2, steps = [{ wait = { duration_s = 1 } }, { turn = { angle_deg = 5 } }] } }",
    ));
    let marks: Vec<_> = run
        .records
        .iter()
        .filter(|record| record.device == Device::Plan)
        .filter_map(|record| match &record.kind {
            RecordKind::StepBegan { path, .. } => Some(format!("+{path}")),
            RecordKind::StepEnded { path } => Some(format!("-{path}")),
            _ => None,
        })
        .collect();
    let expected = [
        "steps[0]",
        "steps[1].repeat[0] (round 1 of 2)",
        "steps[1].repeat[1] (round 1 of 2)",
        "steps[1].repeat[0] (round 2 of 2)",
        "steps[1].repeat[1] (round 2 of 2)",
    ];
    let expected: Vec<_> =
        expected.iter().flat_map(|path| [format!("+{path}"), format!("-{path}")]).collect();
    assert_eq!(marks, expected);
    assert!(run.records.windows(2).all(|pair| pair[0].at <= pair[1].at), "time never goes back");
}
