//! Same plan, seed and version: the same bytes. An additional or worse device does not change the noise of the others.

use emulators::device_file::Devices;
use harness::run::Prepared;
use plan::library::{Kind, names};
use plan::made::Made;
use record::Device;
use tests::devices::shipped;
use tests::plans::{Run, plan_measuring, plan_of, prepared, record_file, run};

/// Uses every source of random numbers: rest, motion by both headings, measured poses.
const ROBOT: &str = r#"
    { bias_test = { duration_s = 20 } },
    { place = { x_m = 0, y_m = 0, heading_deg = 0 } },
    { lap = { direction = "cw", side_m = 0.5 } },
    { heading_source = "odometry" },
    { lap = { direction = "ccw", side_m = 0.5 } },
    { measure_pose = "end" },
"#;

/// The same on the table.
const TABLE: &str = r#"
    { bias_test = { duration_s = 20 } },
    { table_turn = { angle_deg = -90 } },
    { table_turn = { angle_deg = 90 } },
    { bias_residual = { duration_s = 5 } },
"#;

fn steps_for(devices: &Devices) -> &'static str {
    if devices.base.is_some() { ROBOT } else { TABLE }
}

/// Instead of `assert_eq`, which would print megabytes.
fn assert_same(a: &[u8], b: &[u8], what: &str) {
    let first = a.iter().zip(b).position(|(a, b)| a != b);
    assert!(a == b, "{what}: {} and {} bytes, first difference {first:?}", a.len(), b.len());
}

#[test]
fn every_device_file_gives_the_same_record_twice_and_another_with_another_seed() {
    let files = names(Kind::Devices);
    assert!(files.len() >= 4, "{files:?}");
    for name in files {
        let devices = shipped(&name);
        let plan = prepared(&plan_of(steps_for(&devices)), devices);
        let once = record_file(&plan, 1);
        // A run that breaks off in its first step would be repeatable too.
        assert!(once.len() > 10_000, "{name}: {} bytes", once.len());
        assert_same(&once, &record_file(&plan, 1), &name);
        assert!(once != record_file(&plan, 2), "{name}: the seed changes nothing");
    }
}

#[test]
fn the_corrected_laps_of_the_paper_repeat_themselves_byte_by_byte() {
    let plan = Prepared::load("laps-corrected", &Made::default()).expect("the plan ships");
    assert_same(&record_file(&plan, 7), &record_file(&plan, 7), "laps-corrected");
}

fn changed(name: &str, change: impl FnOnce(&mut Devices)) -> Run {
    let mut devices = shipped(name);
    let steps = steps_for(&devices);
    change(&mut devices);
    run(&prepared(&plan_of(steps), devices), 3)
}

/// At rest, a base affects a gyro no more than the floor does.
const AT_REST: &str = "{ bias_test = { duration_s = 20 } }, { wait = { duration_s = 20 } }";

#[test]
fn a_worse_base_does_not_change_the_noise_of_the_gyro() {
    let at_rest = |change: fn(&mut Devices)| {
        let mut devices = shipped("paper");
        change(&mut devices);
        run(&prepared(&plan_of(AT_REST), devices), 3)
    };
    let paper = at_rest(|_| {});
    let worse = at_rest(|devices| {
        let base = &mut devices.base.as_mut().expect("the paper's robot has a base").1;
        base.turn_scale_spread = 0.02;
        base.leakage_spread_deg_per_m = 0.3;
    });
    assert!(paper.sent_by(Device::Gyro).len() > 3_000);
    assert_eq!(paper.sent_by(Device::Gyro), worse.sent_by(Device::Gyro));
}

#[test]
fn a_base_in_place_of_the_table_does_not_change_the_noise_of_the_gyro() {
    let steps = plan_of(AT_REST);
    let on_base = run(&prepared(&steps, shipped("paper")), 3);
    let on_table = run(&prepared(&steps, shipped("paper-table")), 3);
    let (base, table) = (on_base.sent_by(Device::Gyro), on_table.sent_by(Device::Gyro));
    let both = base.len().min(table.len());
    assert!(both > 3_000);
    assert_eq!(base[..both], table[..both]);
}

#[test]
fn a_noisier_gyro_does_not_change_what_the_base_draws_while_odometry_steers() {
    const BY_ODOMETRY: &str = r#"
        { heading_source = "odometry" },
        { straight = { distance_m = 1 } },
        { turn = { angle_deg = 90 } },
        { straight = { distance_m = 1 } },
        { measure_pose = "end" },
    "#;
    let by_odometry = |noise: f64| {
        let mut devices = shipped("paper");
        devices.gyro.1.angle_random_walk_deg_per_sqrt_h *= noise;
        devices.gyro.1.rate_random_walk_deg_per_s_per_sqrt_s = 1e-4 * (noise - 1.0);
        run(&prepared(&plan_measuring(BY_ODOMETRY, "pose.heading", "deg"), devices), 3)
    };
    let (quiet, noisy) = (by_odometry(1.0), by_odometry(3.0));
    assert_ne!(quiet.sent_by(Device::Gyro), noisy.sent_by(Device::Gyro));
    assert_eq!(quiet.sent_by(Device::Base), noisy.sent_by(Device::Base));
    assert_eq!(quiet.observed("pose.heading").len(), 1);
    assert_eq!(quiet.observed("pose.heading"), noisy.observed("pose.heading"));
}

#[test]
fn a_worse_absolute_measurement_changes_only_itself() {
    let paper = changed("paper", |_| {});
    let worse = changed("paper", |devices| devices.absolute.position_limit_m = 0.1);
    for device in [Device::Gyro, Device::Base, Device::Controller] {
        assert!(!paper.sent_by(device).is_empty());
        assert_eq!(paper.sent_by(device), worse.sent_by(device), "{device:?}");
    }
}
