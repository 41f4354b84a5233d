//! From turns of the table to a model, and from the model to corrected turns: within one plan, and from one plan to the
//! next.

use controller::mission::{Command, Report};
use emulators::device_file::Devices;
use identification::dataset::Role;
use identification::model::{Acts, Model};
use plan::models;
use record::RecordKind;
use record::outcome::Outcome;
use tests::devices::{NAVIGATOR, ideal_table};
use tests::plans::{Run, prepared, run};

/// Warms up by 20 K in half an hour, with the paper's scale over temperature, which the controller does not know, and
/// the white noise of its class.
fn warming() -> Devices {
    let mut devices = ideal_table(NAVIGATOR);
    let gyro = &mut devices.gyro.1;
    gyro.ambient_celsius = 22.0;
    gyro.self_heating_kelvin = 20.0;
    gyro.thermal_time_constant_s = 600.0;
    gyro.scale_ppm_per_kelvin = -1_444.0;
    gyro.scale_zero_celsius = 36.98;
    gyro.angle_random_walk_deg_per_sqrt_h = 0.083;
    devices
}

fn plan(steps: &str) -> String {
    format!(
        r#"name = "loop"
title = "Identified and corrected"
devices = "paper-table"
steps = [
    {{ wait = {{ duration_s = 2 }} }},
    {steps}
]

[[measurement]]
name = "error"
doc = "Error of one turn"
quantity = "table.error"
unit = "deg"
check = {{ all_within = [-100, 100] }}

[[measurement]]
name = "effects"
doc = "What was found"
quantity = "identification.effects"
unit = "1"
check = {{ all_within = [0, 9] }}

[[measurement]]
name = "after"
doc = "What is left"
quantity = "identification.after"
unit = "deg"
check = {{ all_within = [0, 9] }}

[[measurement]]
name = "before"
doc = "What there was"
quantity = "identification.before"
unit = "deg"
check = {{ all_within = [0, 9] }}
"#
    )
}

fn turns(times: u32, label: &str) -> String {
    format!(
        r#"{{ repeat = {{ times = {times}, steps = [
            {{ bias_test = {{ duration_s = 5 }} }},
            {{ table_turn = {{ angle_deg = -360 }} }},
            {{ table_turn = {{ angle_deg = 360 }} }},
        ] }}, label = "{label}" }},"#
    )
}

fn worst(errors: &[f64]) -> f64 {
    errors.iter().fold(0.0, |worst, error| worst.max(error.abs()))
}

fn identified() -> Run {
    let steps = turns(40, "warm_up")
        + r#"{ identify = { from = "turns", name = "shape", over = "warm_up" } },
             { use_model = "shape" },"#
        + &turns(5, "corrected")
        + r#"{ use_model = "none" },"#
        + &turns(1, "plain");
    run(&prepared(&plan(&steps), warming()), 1)
}

#[test]
fn a_model_is_identified_kept_and_corrects() {
    let done = identified();
    assert_eq!(done.simulated.ending.outcome, Outcome::Passed, "{:?}", done.simulated.ending);
    let errors = done.observed("table.error");
    let (raw, corrected, plain) = (&errors[..80], &errors[80..90], &errors[90..]);
    assert!(worst(raw) > 5.0, "{}", worst(raw));
    // White noise leaves 0.083/60 sqrt(14 s) of a turn and as much of the test; the steps of the wire 0.02.
    assert!(worst(corrected) < 0.1, "{corrected:?}");
    assert!(worst(plain) > 1.0, "{plain:?}");
    let one = |quantity| done.observed(quantity)[0];
    assert!(one("identification.effects") >= 1.0);
    assert!(one("identification.after") < 0.1 && one("identification.before") > 1.0);
    let model = &done.simulated.made.models["shape"];
    assert_eq!(model.fields.get("temperature"), Some(&Role::Temperature));
    assert!(model.terms.iter().any(|term| term.term == Acts::Scale && !term.drivers.is_empty()));
    let text = models::to_toml(model, "made by a test");
    assert_eq!(&Model::from_toml(&text).unwrap(), model);
    assert!(models::to_json(&done.simulated.made.findings["shape"]).contains("held_out"));
    let note = |kind: &RecordKind| matches!(kind, RecordKind::Note(t) if t.starts_with("identify"));
    assert!(done.records.iter().any(|record| note(&record.kind)));
}

#[test]
fn a_later_plan_uses_the_model_of_an_earlier_one() {
    let made = identified().simulated.made;
    let steps = r#"{ use_model = "shape" },"#.to_owned() + &turns(10, "other_day");
    let mut prepared = prepared(&plan(&steps), warming());
    let missing = run(&prepared, 2);
    assert_eq!(missing.simulated.ending.outcome, Outcome::Error);
    assert!(missing.simulated.ending.reason.unwrap().contains("no model \"shape\""));
    prepared.models = made.models;
    let errors = run(&prepared, 2).observed("table.error");
    assert!(errors.len() == 20 && worst(&errors) < 0.15, "{errors:?}");
}

#[test]
fn nothing_to_identify_from_fails_the_run() {
    let steps = turns(1, "few")
        + r#"{ use_model = "none" },
             { set_parameter = { parameter = "gyro.scale_ppm", value = 1 } },
             { use_calibration = "temperature" },
             { identify = { from = "turns", name = "shape" } },"#;
    let done = run(&prepared(&plan(&steps), warming()), 1);
    assert_eq!(done.simulated.ending.outcome, Outcome::Failed);
    let reason = done.simulated.ending.reason.unwrap();
    assert!(reason.contains("no turns were observed under the calibration in force"), "{reason}");
}

const FAST: &str =
    "{ table_turn = { angle_deg = -360, rate_deg_per_s = 90, acceleration_deg_per_s2 = 400 } },";

/// When the table stands, the controller's mean rate is still that of the turn.
#[test]
fn a_model_is_taken_up_once_the_controller_reports_rest() {
    for taken in [r#"{ use_model = "none" }"#, r#"{ use_calibration = "none" }"#] {
        let done = run(&prepared(&plan(&(FAST.to_owned() + taken)), warming()), 1);
        let moving =
            |kind: &RecordKind| matches!(kind, RecordKind::Report(Report::State(s)) if s.moving);
        let last = done.records.iter().rposition(|record| moving(&record.kind)).unwrap();
        let applied = |kind: &RecordKind| matches!(kind, RecordKind::Command(c) if matches!(**c, Command::SetCalibration(_)));
        let at = done.records.iter().position(|record| applied(&record.kind)).unwrap();
        assert!(last < at, "{taken}: told to in motion");
        assert_eq!(done.simulated.ending.outcome, Outcome::Passed, "{:?}", done.simulated.ending);
    }
}

#[test]
fn a_gyro_that_never_comes_to_rest_ends_the_run_with_the_reason() {
    let mut devices = ideal_table(NAVIGATOR);
    // Above the controller's limit for a bias.
    devices.gyro.1.bias_deg_per_h = 3_600.0;
    let done = run(&prepared(&plan(r#"{ use_model = "none" }"#), devices), 1);
    assert_eq!(done.simulated.ending.outcome, Outcome::Timeout);
    let reason = done.simulated.ending.reason.unwrap();
    assert!(reason.contains("the controller does not report rest"), "{reason}");
}
