//! Mutants that break no property in a normal run: the intended row of a plan fails with the mutant, and passes
//! without.

use controller::Mutant;
use controller::calibration::Calibration;
use emulators::device_file::Devices;
use harness::operator::Answers;
use harness::run::{Prepared, verdicts};
use plan::library::{Kind, names};
use plan::made::Made;
use plan::{Declared, Plan, Proves, Rig};
use record::outcome::Outcome;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use tests::devices::{NAVIGATOR, ideal_table};

/// Mutants, each with a plan and the rows of it that fail. Nothing else of the run changes its verdict.
///
/// That the same rows pass without is in the golden table.
const FAILS: [(Mutant, &str, &[&str]); 24] = [
    (Mutant::LooseStop, "straight-accuracy", &["stop_error", "true_stop_error"]),
    (Mutant::SteeringLoopOpen, "straight-accuracy", &["heading_held", "true_heading_held"]),
    (Mutant::SpeedIgnored, "straight-accuracy", &["side_duration"]),
    (Mutant::HeadingNotHeld, "turn-accuracy", &["true_stop_error", "true_stop_error_all_turns"]),
    (Mutant::RateIgnored, "turn-accuracy", &["whole_turn_duration"]),
    (Mutant::CcwSign, "laps-observed", &["gyro_return_orientation"]),
    (Mutant::SpeedIgnored, "laps-observed", &["lap_duration"]),
    (Mutant::CcwSign, "verification", &["table_error", "table_error_typical"]),
    (Mutant::SignIgnored, "verification-dsp3000", &["table_error"]),
    (Mutant::FirstFactorAlone, "correction-factors", &["cw_by_both", "ccw_by_both"]),
    (Mutant::SwappedDirections, "correction-factors", &["by_both", "cw_by_both", "ccw_by_both"]),
    (
        Mutant::CcwSign,
        "correction-factors",
        &["by_temperature", "directions_apart", "by_both", "ccw_by_both"],
    ),
    (Mutant::TurnByOdometry, "laps-corrected", &["return_orientation"]),
    (
        Mutant::TurnNotWritten,
        "laps-corrected",
        &["base_return_orientation", "base_heading_on_the_way"],
    ),
    (Mutant::MirroredReckoning, "laps-corrected", &["base_position_on_the_way"]),
    (
        Mutant::WrongPoseDownloaded,
        "laps-corrected",
        &["base_heading_on_the_way", "base_position_on_the_way"],
    ),
    (
        Mutant::WrongPoseDownloaded,
        "laps-corrected-serial",
        &["base_heading_on_the_way", "base_position_on_the_way"],
    ),
    (
        Mutant::CcwSign,
        "laps-corrected",
        &[
            "return_orientation",
            "return_position",
            "base_return_orientation",
            "base_return_position",
            "base_heading_on_the_way",
            "base_position_on_the_way",
        ],
    ),
    (Mutant::ShortInch, "live-side", &["end_x"]),
    (Mutant::SteeringReversed, "live-side", &["heading_held", "end_x", "end_y"]),
    (Mutant::CcwSign, "live-side", &["end_heading"]),
    (Mutant::SpeedIgnored, "live-side", &["side_duration"]),
    (Mutant::LooseStop, "live-side", &["straight_stop_error"]),
    (Mutant::CcwSign, "live-table-run", &["table_error"]),
];

fn shipped(plan: &str) -> Prepared {
    Prepared::load(plan, &Made::default()).expect("the plan ships")
}

/// The rows that fail, of a run that carries out every step.
fn failed(prepared: &Prepared) -> Vec<String> {
    let run = verdicts(prepared, 1, &Answers::default(), &mut |_| true);
    assert_eq!(run.ending.outcome, Outcome::Passed, "{:?}", run.ending.reason);
    let failed = run.measurements.into_iter().filter(|row| !row.verdict.is_acceptable());
    failed.map(|row| row.name).collect()
}

#[test]
fn each_mutant_fails_its_rows_and_no_other() {
    for (mutant, plan, rows) in FAILS {
        let prepared = Prepared { mutant: Some(mutant), ..shipped(plan) };
        assert_eq!(failed(&prepared), rows, "{plan}: {}", mutant.name());
    }
}

/// A row of another plan with the same quantity and filter counts as the same.
#[test]
fn every_row_that_tests_the_controller_has_a_mutant_that_fails_it() {
    let what = |row: &Declared| format!("{} where {:?}", row.quantity, row.filter);
    let rows_of = |plan: &str| shipped(plan).plan.measurements.clone();
    let fails: BTreeSet<String> = FAILS
        .iter()
        .flat_map(|(_, plan, names)| {
            let rows = rows_of(plan);
            let row =
                move |name: &&str| rows.iter().find(|row| row.name.as_str() == *name).cloned();
            names.iter().map(move |name| what(&row(name).expect("the plan has it")))
        })
        .collect();
    for plan in names(Kind::Plan) {
        for row in rows_of(&plan) {
            let tests = row.proves == Some(Proves::TestsTheController);
            assert!(!tests || fails.contains(&what(&row)), "{plan}: nothing fails {}", row.name);
        }
    }
}

/// Checks that `row` fails with the mutant, and that every row passes without.
fn caught(mutant: Mutant, row: &str, mut prepared: Prepared) {
    assert_eq!(failed(&prepared), Vec::<String>::new(), "without {}", mutant.name());
    prepared.mutant = Some(mutant);
    let failed = failed(&prepared);
    assert!(failed.iter().any(|name| name == row), "{}: {failed:?}", mutant.name());
}

/// A plan of steps on a table, whose turns must be correct within 0.25 deg, except those labelled `wrong`.
fn on_a_table(steps: &str, devices: Devices, calibration: Calibration) -> Prepared {
    let text = format!(
        r#"
name = "scenario"
title = "A scenario"
devices = "none"
steps = [{steps}]

[[measurement]]
name = "right"
doc = "Error of a turn"
quantity = "table.error"
where = {{ "during.right" = 1 }}
unit = "deg"
check = {{ all_within = [-0.25, 0.25] }}

[[measurement]]
name = "wrong"
doc = "Error of a turn that is known to be wrong"
quantity = "table.error"
where = {{ "during.wrong" = 1 }}
unit = "deg"
check = {{ rms_within = [0.9, 1.1] }}
"#
    );
    let plan = Plan::parse("scenario", &text).unwrap_or_else(|error| panic!("{error}"));
    let calibrations = BTreeMap::from([("own".to_owned(), calibration)]);
    Prepared::new(Arc::new(plan), Rig::of_robot(devices), calibrations, BTreeMap::new())
}

fn turns(label: &str) -> String {
    let turn = |angle| {
        format!(
            "{{ table_turn = {{ angle_deg = {angle}, rate_deg_per_s = 30, acceleration_deg_per_s2 = 15 }}, label = \"{label}\" }}"
        )
    };
    format!("{}, {}", turn(-360), turn(360))
}

#[test]
fn the_bias_method_counts() {
    let mut devices = ideal_table(NAVIGATOR);
    // 1 deg over the 14 s of a turn and the rest around it.
    devices.gyro.1.bias_deg_per_h = 255.0;
    let steps = format!(
        r#"{{ bias_test = {{ duration_s = 20 }} }}, {}, {{ bias_method = "none" }}, {}"#,
        turns("right"),
        turns("wrong")
    );
    caught(Mutant::BiasMethodIgnored, "wrong", on_a_table(&steps, devices, Calibration::default()));
}

/// The bias of the paper's own unit is within the band of a turn.
#[test]
fn a_bias_that_is_not_taken_off_fails_the_table_run() {
    let mut prepared = shipped("live-table-run");
    assert_eq!(failed(&prepared), Vec::<String>::new());
    let test = "{ bias_test = { duration_s = 20 } },";
    let text = include_str!("../../../test-plans/live-table-run.toml");
    let ignored = text.replace(test, &format!("{test} {{ bias_method = \"none\" }},"));
    assert_ne!(ignored, text);
    prepared.plan = Arc::new(Plan::parse("ignored", &ignored).expect("a plan"));
    assert_eq!(failed(&prepared), ["table_error"]);
}

#[test]
fn what_is_noticed_shows() {
    let text = r#"
name = "scenario"
title = "A line that loses a twentieth of its samples"
devices = "none"
steps = [{ wait = { duration_s = 60 } }]

[[fault]]
target = "gyro"
what = { drop = { loss_percent = 5 } }

[[measurement]]
name = "said"
doc = "Changes of health to degraded"
quantity = "health.degraded"
unit = "1"
check = { all_within = { at_least = 1 } }
"#;
    let plan = Plan::parse("scenario", text).unwrap_or_else(|error| panic!("{error}"));
    let rig = Rig::of_robot(ideal_table(NAVIGATOR));
    let prepared = Prepared::new(Arc::new(plan), rig, BTreeMap::new(), BTreeMap::new());
    caught(Mutant::HealthSilent, "said", prepared);
}

/// An error of the gyro, not of the controller, which nothing corrects: cw and ccw differ.
#[test]
fn one_percent_between_the_directions_is_not_alike() {
    let mut prepared = shipped("temperature-calibration");
    let mut devices = tests::devices::shipped("paper-table");
    devices.gyro.1.scale_asymmetry_ppm = 10_000.0;
    prepared.rig = Rig::of_robot(devices);
    assert_eq!(failed(&prepared), ["intercept_cw", "intercept_ccw"]);
}
