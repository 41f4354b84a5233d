//! Mutants that break no property in a normal run: the intended row of a plan fails with the mutant, and passes
//! without.

use controller::Mutant;
use controller::calibration::{Calibration, Factor};
use emulators::device_file::Devices;
use harness::operator::Answers;
use harness::run::{Prepared, verdicts};
use plan::made::Made;
use plan::{Plan, Rig};
use std::collections::BTreeMap;
use std::sync::Arc;
use tests::devices::{NAVIGATOR, ideal_table};

/// Checks that `row` fails with the mutant, and that every row passes without.
fn caught(mutant: Mutant, row: &str, mut prepared: Prepared) {
    let mut rows = |planted| {
        prepared.mutant = planted;
        let run = verdicts(&prepared, 1, &Answers::default(), &mut |_| true);
        let failed = run.measurements.into_iter().filter(|row| !row.verdict.is_acceptable());
        failed.map(|row| row.name).collect::<Vec<_>>()
    };
    assert_eq!(rows(None), Vec::<String>::new(), "without {}", mutant.name());
    let failed = rows(Some(mutant));
    assert!(failed.iter().any(|name| name == row), "{}: {failed:?}", mutant.name());
}

fn shipped(plan: &str) -> Prepared {
    Prepared::load(plan, &Made::default()).expect("the plan ships")
}

#[test]
fn the_base_is_told_where_it_is_not() {
    let row = "base_position_on_the_way";
    caught(Mutant::WrongPoseDownloaded, row, shipped("laps-corrected"));
    caught(Mutant::WrongPoseDownloaded, row, shipped("laps-corrected-serial"));
    caught(Mutant::MirroredReckoning, row, shipped("laps-corrected"));
}

#[test]
fn orders_are_as_fast_as_they_say() {
    caught(Mutant::SpeedIgnored, "side_duration", shipped("straight-accuracy"));
    caught(Mutant::RateIgnored, "whole_turn_duration", shipped("turn-accuracy"));
}

#[test]
fn the_heading_is_held_at_rest() {
    caught(Mutant::HeadingNotHeld, "true_stop_error", shipped("turn-accuracy"));
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

/// A gyro that reads a counter-clockwise turn 1 deg too large and a clockwise turn 1 deg too small, and both half a
/// percent too large.
fn by_two_factors() -> Prepared {
    let mut devices = ideal_table(NAVIGATOR);
    let asymmetry_ppm = 2.0 / 360.0 * 1e6;
    devices.gyro.1.scale_asymmetry_ppm = asymmetry_ppm;
    devices.gyro.1.scale_ppm = 5_000.0;
    let directions = Factor::Direction { cw_error_deg: -1.0, ccw_error_deg: 1.0 };
    let factors = [directions, Factor::Constant(1.0 / 1.005)].into_iter().collect();
    let steps = format!(
        r#"{{ bias_test = {{ duration_s = 20 }} }}, {{ use_calibration = "own" }}, {}, {{ use_calibration = "none" }},
        {{ set_parameter = {{ parameter = "gyro.scale_ppm", value = 0 }} }}, {}"#,
        turns("right"),
        turns("wrong")
    );
    on_a_table(&steps, devices, Calibration { factors, ..Calibration::default() })
}

#[test]
fn directional_factors_and_chains_of_factors() {
    caught(Mutant::SwappedDirections, "right", by_two_factors());
    caught(Mutant::FirstFactorAlone, "right", by_two_factors());
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
    let failed = |prepared: &Prepared| {
        let run = verdicts(prepared, 1, &Answers::default(), &mut |_| true);
        let failed = run.measurements.into_iter().filter(|row| !row.verdict.is_acceptable());
        failed.map(|row| row.name).collect::<Vec<_>>()
    };
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
    let run = verdicts(&prepared, 1, &Answers::default(), &mut |_| true);
    let failed = run.measurements.iter().filter(|row| !row.verdict.is_acceptable());
    let failed: Vec<_> = failed.map(|row| row.name.as_str()).collect();
    assert_eq!(failed, ["intercept_cw", "intercept_ccw"]);
}
