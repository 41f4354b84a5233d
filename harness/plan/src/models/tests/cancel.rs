//! An emulated gyro with the errors of a model, and a controller with the corrections of the same model: only noise
//! remains. Emulator and controller have separate code for evaluating terms.

use super::{corrections, learned, model, term};
use controller::calibration::Calibration;
use controller::config::{Config, GyroConfig, MotionConfig};
use controller::mission::{Command, Mission, Report};
use controller::{Controller, Input, Port};
use emulators::gyro::{GyroEmulator, GyroParameters};
use identification::model::Model;
use std::f64::consts::TAU;
use wire::gyro::{GyroFormat, GyroStream, OutputMode};
use wire::packet::Packet;
use wire::time::Timestamp;
use wire::units::Angle;

const STREAM: GyroStream =
    GyroStream { format: GyroFormat::Navigator, mode: OutputMode::Rate, reversed: false };

/// Before this time the slope of the temperature is not known.
const FROM_S: f64 = 100.0;
const UNTIL_S: f64 = 700.0;

/// The carrier turns back and forth, 5 deg/s more in one direction, so that no effect cancels by itself.
fn heading(t: f64) -> Angle {
    let period_s = 60.0;
    let swing = 30.0 * period_s / TAU * (1.0 - (TAU * t / period_s).cos());
    Angle::from_deg(5.0 * t + swing)
}

/// Heading error in degrees that accumulates in ten minutes of warming up.
fn error_deg(model: &Model, corrected: bool) -> f64 {
    let learned = learned(model).unwrap();
    assert!(learned.parameters.is_empty());
    let parameters = GyroParameters {
        ambient_celsius: 20.0,
        self_heating_kelvin: 20.0,
        thermal_time_constant_s: 1_000.0,
        terms: learned.terms,
        ..Default::default()
    };
    let mut gyro = GyroEmulator::new(parameters, STREAM, 1, "gyro");
    let config = Config::new(GyroConfig::new(STREAM), None, MotionConfig::default());
    let mut controller = Controller::new(config, Timestamp::ZERO);
    if corrected {
        let corrections = corrections(model).unwrap();
        let calibration = Calibration { corrections, ..Calibration::default() };
        let command = Command::SetCalibration(calibration);
        controller.command(Timestamp::ZERO, Mission { id: 1, command });
    }
    let (mut before, mut after) = (None, None);
    while gyro.next_wakeup() <= Timestamp::from_secs_f64(UNTIL_S) {
        let now = gyro.next_wakeup();
        let mut packet = Packet::new();
        if gyro.wake(now, heading(now.as_secs_f64()), &mut packet) {
            controller.receive(now, Port::Gyro, Input::Bytes(packet.as_slice()));
        }
        if controller.next_wakeup() <= now {
            controller.wake(now);
        }
        while let Some(report) = controller.report() {
            let Report::State(state) = report else {
                assert!(!matches!(report, Report::Refused { .. }), "{report:?}");
                continue;
            };
            let error = state.gyro_heading - heading(now.as_secs_f64());
            if now.as_secs_f64() >= FROM_S {
                before.get_or_insert(error);
            }
            after = Some(error);
        }
    }
    (after.unwrap() - before.unwrap()).deg()
}

/// Tolerance: steps of 0.003 deg/s, which mostly average out, steps of the temperature itself, and times that differ by
/// a sample.
const NOISE_DEG: f64 = 0.02;

#[track_caller]
fn cancels(terms: &[&str], share_left_max: f64) {
    let model = model(terms);
    let (wrong, left) = (error_deg(&model, false), error_deg(&model, true));
    assert!(wrong.abs() > 10.0 * NOISE_DEG, "{terms:?} does nothing: {wrong}");
    let allowed = NOISE_DEG + share_left_max * wrong.abs();
    assert!(left.abs() < allowed, "{terms:?}: {left} of {wrong} is left");
}

#[test]
fn every_form_cancels() {
    let bias = "deg/s";
    let values = ["value_1", "value_2", "value_3", "value_4"];
    let spline = values.iter().zip([0.0, 0.01, 0.005, 0.02]).map(|(name, v)| (*name, v, bias));
    let mut of_rate: Vec<_> =
        values.iter().zip([0.0, 4e-3, 1e-3, 2e-3]).map(|(name, v)| (*name, v, "1")).collect();
    of_rate.push(("knot", 1.0, "deg/s"));
    for term in [
        term("bias", "", "constant", &[("value", 0.01, bias)]),
        term("scale", "", "constant", &[("value", 0.01, "1")]),
        term("scale", "coil", "linear", &[("slope", 1e-3, "1/K"), ("origin", 20.0, "Cel")]),
        term(
            "scale",
            "coil",
            "quadratic",
            &[("coefficient", 1e-4, "1/K^2"), ("origin", 15.0, "Cel")],
        ),
        term(
            "bias",
            "coil",
            "cubic",
            &[("coefficient", 1e-5, "deg/s/K^3"), ("origin", 20.0, "Cel")],
        ),
        term(
            "bias",
            "since_on",
            "exponential",
            &[("amplitude", 0.02, bias), ("time_constant", 5.0, "min")],
        ),
        term("bias", "harmonic_1(psi)", "harmonic", &[("cos", 0.03, bias), ("sin", 0.02, bias)]),
        term("bias", "harmonic_2(psi)", "harmonic", &[("cos", 0.04, bias), ("sin", 0.04, bias)]),
        term(
            "bias",
            "periodic(since_on)",
            "periodic",
            &[("cos", 0.01, bias), ("sin", 0.02, bias), ("period", 500.0, "s")],
        ),
        term("bias", "step(since_on)", "step", &[("size", 0.01, bias), ("at", 321.0, "s")]),
        term("scale", "coil", "hinge", &[("slope", 2e-3, "1/K"), ("at", 25.0, "Cel")]),
        term(
            "bias",
            "coil",
            "bump",
            &[("height", 0.02, bias), ("centre", 26.0, "Cel"), ("width", 2.0, "K")],
        ),
        term(
            "bias",
            "coil",
            "tanh",
            &[("height", 0.02, bias), ("centre", 24.0, "Cel"), ("width", 3.0, "K")],
        ),
        term("bias", "coil", "spline", &spline.collect::<Vec<_>>()) + "\nknots = [20, 24, 27, 31]",
        term("scale", "abs(spin)", "spline", &of_rate) + "\nknots = [0, 12, 25, 40]",
        term(
            "scale",
            "coil since_on",
            "product",
            &[("coefficient", 2e-6, "1/K/s"), ("origin", 20.0, "Cel")],
        ),
    ] {
        cancels(&[&term], 0.005);
    }
}

#[test]
fn every_driver_cancels() {
    let bias = "deg/s";
    for term in [
        term(
            "bias",
            "branch_of(coil)",
            "linear",
            &[("slope", -0.01, "deg/s/K"), ("half_width", 1.5, "K")],
        ),
        term(
            "scale",
            "lag_of(coil)",
            "linear",
            &[("slope", 1e-3, "1/K"), ("origin", 20.0, "Cel"), ("time_constant", 120.0, "s")],
        ),
        term("bias", "trend(since_on)", "linear", &[("slope", 0.1, "deg/s/h")]),
        term("bias", "spin", "linear", &[("slope", 0.01, "1")]),
        term("scale", "spin", "quadratic", &[("coefficient", 1e-5, "1/(deg/s)^2")]),
        term("bias", "abs(spin)", "linear", &[("slope", 1e-3, "1")]),
        term("scale", "direction", "linear", &[("slope", 5e-3, "1")]),
        term("bias", "sign(spin)", "linear", &[("slope", 0.02, bias)]),
    ] {
        cancels(&[&term], 0.005);
    }
    // The measured slope covers the last minute and lags by half a minute, which is 3 % of the time constant.
    cancels(&[&term("bias", "rate_of(coil)", "linear", &[("h", 1.0, "deg/s/(K/s)")])], 0.04);
}

#[test]
fn a_whole_model_cancels() {
    cancels(
        &[
            &term("scale", "coil", "linear", &[("slope", -1.4e-3, "1/K"), ("origin", 37.0, "Cel")]),
            &term("scale", "abs(spin)", "quadratic", &[("coefficient", -1e-6, "1/(deg/s)^2")]),
            &term("scale", "direction", "linear", &[("slope", 2e-4, "1")]),
            &term("bias", "rate_of(coil)", "linear", &[("h", 0.05, "deg/s/(K/s)")]),
            &term(
                "bias",
                "harmonic_1(psi)",
                "harmonic",
                &[("cos", 0.002, "deg/s"), ("sin", 0.0, "deg/s")],
            ),
        ],
        0.005,
    );
}
