//! Noise, and effects of the plain model: nothing is added.

use super::{Story, unit};
use emulators::device_file::Devices;
use identification::finding::Verdict;
use tests::devices::shipped;
use wire::gyro::{GyroFormat, OutputMode};

#[track_caller]
fn adds_nothing(devices: Devices) {
    let story = Story::of(devices);
    story.is_carried_out();
    // Random-walk noise may be named, and nothing else.
    let added = story.finding().effects.iter().any(|effect| effect.term != "noise");
    assert!(!added, "{}", story.in_words());
    assert_eq!(story.finding().verdict, Verdict::NothingMissing);
}

#[test]
fn white() {
    adds_nothing(unit(&[("bias_instability_rms_deg_per_s", 0.0)]));
}

/// From the paper's data sheet.
#[test]
fn flicker() {
    adds_nothing(unit(&[("bias_instability_rms_deg_per_s", 0.005)]));
}

/// A tenth of the class: the full value wanders by 0.1 deg/s in these hours.
#[test]
fn random_walk() {
    adds_nothing(unit(&[("rate_random_walk_deg_per_s_per_sqrt_s", 1e-4)]));
}

/// Another stream: increments in steps, and a thermometer of 0.5 K (assumption).
#[test]
fn quantised() {
    let mut devices = unit(&[("temperature_resolution_kelvin", 0.5)]);
    devices.gyro.0.format = GyroFormat::Dsp3000Ascii;
    devices.gyro.0.mode = OutputMode::Increment;
    adds_nothing(devices);
}

/// More than twice the data sheet (assumption); more would make a bias test report motion.
#[test]
fn heavier_white() {
    adds_nothing(unit(&[("angle_random_walk_deg_per_sqrt_h", 0.2)]));
}

/// A constant scale error and a bias, which the plain model contains.
#[test]
fn what_the_plain_model_has() {
    adds_nothing(unit(&[("scale_ppm", 5_000.0), ("bias_deg_per_h", 10.0)]));
}

/// The shipped unit does have something to find.
#[test]
fn the_shipped_unit_is_no_null() {
    assert!(!Story::of(shipped("undeclared-table")).finding().effects.is_empty());
}
