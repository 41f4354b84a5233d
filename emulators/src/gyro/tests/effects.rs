//! Effects that a plain model lacks, each alone.

use super::{NAVIGATOR, gyro, rate, run};
use crate::gyro::{GyroEmulator, GyroParameters};
use wire::units::Angle;

/// The gyro's readings in deg/s at these instants, on a carrier that turns at `deg_per_s`.
fn readings(gyro: &mut GyroEmulator, deg_per_s: f64, at_s: &[f64]) -> Vec<f64> {
    at_s.iter()
        .map(|&until| {
            let mut last = f64::NAN;
            run(gyro, until, |t| Angle::from_deg(deg_per_s * t), |sample| last = rate(sample));
            last
        })
        .collect()
}

fn at_rest(parameters: GyroParameters, at_s: &[f64]) -> Vec<f64> {
    readings(&mut gyro(parameters, NAVIGATOR), 0.0, at_s)
}

/// One deg/h in deg/s.
const DEG_PER_H: f64 = 1.0 / 3_600.0;

#[track_caller]
fn close(found: &[f64], expected: &[f64], within: f64) {
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < within, "{found} is not {expected}");
    }
}

#[test]
fn hysteresis_has_a_branch_for_warming_and_one_for_cooling() {
    let mut gyro = gyro(
        GyroParameters {
            ambient_celsius: 20.0,
            thermal_time_constant_s: 10.0,
            hysteresis_deg_per_h_per_kelvin: 3_600.0,
            hysteresis_half_width_kelvin: 2.0,
            ..Default::default()
        },
        NAVIGATOR,
    );
    close(&readings(&mut gyro, 0.0, &[5.0]), &[0.0], 1e-9);
    gyro.set_parameter("ambient_celsius", 30.0).unwrap();
    close(&readings(&mut gyro, 0.0, &[205.0]), &[-2.0], 1e-6);
    gyro.set_parameter("ambient_celsius", 20.0).unwrap();
    close(&readings(&mut gyro, 0.0, &[405.0]), &[2.0], 1e-6);
    // A change of less than the play leaves the branch half-way.
    gyro.set_parameter("ambient_celsius", 21.0).unwrap();
    close(&readings(&mut gyro, 0.0, &[605.0]), &[1.0], 1e-6);
}

#[test]
fn warm_up_ageing_and_a_step_go_with_the_time_since_power_up() {
    let powered_before_s = 1_000.0;
    let times = [10.0, 50.0, 200.0];
    let warm_up = GyroParameters {
        warm_up_bias_deg_per_h: 3_600.0,
        warm_up_bias_time_constant_s: 500.0,
        powered_before_s,
        ..Default::default()
    };
    close(&at_rest(warm_up, &times), &times.map(|t| (-(t + 1e3) / 500.0).exp()), 1e-5);
    let bias = GyroParameters {
        bias_ageing_deg_per_h_per_h: 3_600.0,
        powered_before_s,
        ..Default::default()
    };
    close(&at_rest(bias, &times), &times.map(|t| (t + 1e3) / 3_600.0), 1e-5);
    let scale =
        GyroParameters { scale_ageing_ppm_per_h: 3_600.0, powered_before_s, ..Default::default() };
    let shown = readings(&mut gyro(scale, NAVIGATOR), 100.0, &times);
    close(&shown, &times.map(|t| 100.0 * (1.0 + 1e-6 * (t + 1e3))), 1e-5);
    let step = GyroParameters {
        bias_step_deg_per_h: 3_600.0,
        bias_step_at_s: 1_100.5,
        powered_before_s,
        ..Default::default()
    };
    close(&at_rest(step, &[50.0, 100.4, 100.6, 200.0]), &[0.0, 0.0, 1.0, 1.0], 1e-9);
}

#[test]
fn a_disturbance_has_its_period() {
    let parameters = GyroParameters {
        periodic_bias_deg_per_h: 3_600.0,
        periodic_bias_period_s: 8.0,
        ..Default::default()
    };
    close(
        &at_rest(parameters, &[1.0, 2.0, 4.0, 6.0, 10.0]),
        &[0.5f64.sqrt(), 1.0, 0.0, -1.0, 1.0],
        0.01,
    );
}

#[test]
fn the_field_goes_with_the_heading_and_vanishes_over_a_turn() {
    let parameters = GyroParameters {
        magnetic_bias_deg_per_h: 5.0,
        magnetic_heading_deg: 30.0,
        ..Default::default()
    };
    for heading in [0.0, 30.0, 120.0, 210.0] {
        let mut gyro = gyro(parameters.clone(), NAVIGATOR);
        let mut last = 0.0;
        run(&mut gyro, 1.0, |_| Angle::from_deg(heading), |sample| last = rate(sample));
        close(&[last], &[5.0 * DEG_PER_H * (heading - 30.0).to_radians().cos()], 1e-9);
    }
    let mut gyro = gyro(parameters, NAVIGATOR);
    let (mut off, mut outputs) = (0.0, 0);
    // A turn in 12 s, from the first output on.
    run(
        &mut gyro,
        12.0,
        |t| Angle::from_deg(30.0 * t),
        |sample| {
            off += (rate(sample) - 30.0) * 0.01;
            outputs += 1;
        },
    );
    assert!(outputs >= 1_199 && off.abs() < 5.0 * DEG_PER_H * 0.02, "{off}");
}

#[test]
fn motors_and_supply_add_to_the_bias() {
    let parameters = GyroParameters {
        bias_deg_per_h_per_ampere: 2.0,
        bias_deg_per_h_per_volt: 3.0,
        ..Default::default()
    };
    let mut gyro = gyro(parameters, NAVIGATOR);
    assert!(gyro.feels_motors());
    close(&readings(&mut gyro, 0.0, &[1.0]), &[0.0], 1e-12);
    gyro.set_motor_current(4.0);
    gyro.set_parameter("supply_deviation_volt", -1.0).unwrap();
    close(&readings(&mut gyro, 0.0, &[2.0]), &[(8.0 - 3.0) * DEG_PER_H], 1e-9);
    assert!((gyro.truth().bias.deg_per_h() - 5.0).abs() < 1e-6);
}

#[test]
fn motors_pull_the_supply_down() {
    let parameters = GyroParameters {
        bias_deg_per_h_per_volt: 5.0,
        supply_sag_volt_per_ampere: 0.1,
        ..Default::default()
    };
    let mut gyro = gyro(parameters, NAVIGATOR);
    assert!(gyro.feels_motors());
    gyro.set_motor_current(6.0);
    close(&readings(&mut gyro, 0.0, &[1.0]), &[-5.0 * 0.6 * DEG_PER_H], 1e-9);
    gyro.set_motor_current(0.0);
    close(&readings(&mut gyro, 0.0, &[2.0]), &[0.0], 1e-12);
    gyro.set_parameter("bias_deg_per_h_per_volt", 0.0).unwrap();
    assert!(!gyro.feels_motors());
}

/// The Earth's rate, 15.041 deg/h, at 42.3 deg north: 10.12 deg/h up, 11.12 deg/h to the north.
fn on_the_earth(axis_tilt_deg: f64) -> GyroParameters {
    GyroParameters {
        earth_rate_deg_per_h: 15.041,
        latitude_deg: 42.3,
        tilt_north_heading_deg: 30.0,
        axis_tilt_deg,
        ..Default::default()
    }
}

#[test]
fn an_upright_axis_sees_the_vertical_part_of_the_earths_rate() {
    close(&at_rest(on_the_earth(0.0), &[1.0]), &[10.123 * DEG_PER_H], 1e-6);
    let south = GyroParameters { latitude_deg: -42.3, ..on_the_earth(0.0) };
    close(&at_rest(south, &[1.0]), &[-10.123 * DEG_PER_H], 1e-6);
    let off = GyroParameters { earth_rate_deg_per_h: 0.0, ..on_the_earth(2.0) };
    close(&at_rest(off, &[1.0]), &[0.0], 1e-12);
}

#[test]
fn a_tilted_axis_sees_the_horizontal_part_with_the_heading() {
    for heading in [0.0, 30.0, 120.0, 210.0f64] {
        let mut gyro = gyro(on_the_earth(2.0), NAVIGATOR);
        let mut last = 0.0;
        run(&mut gyro, 1.0, |_| Angle::from_deg(heading), |sample| last = rate(sample));
        // The angle between the axis and the Earth's, as unit vectors up and to the north.
        let (tilt, latitude) = (2f64.to_radians(), 42.3f64.to_radians());
        let north = tilt.sin() * (heading - 30.0).to_radians().cos();
        let expected = 15.041 * (tilt.cos() * latitude.sin() + north * latitude.cos());
        close(&[last], &[expected * DEG_PER_H], 1e-9);
    }
}

#[test]
fn below_the_dead_zone_nothing_is_read() {
    let parameters =
        GyroParameters { dead_zone_deg_per_s: 0.005, bias_deg_per_h: 3.6, ..Default::default() };
    for (turning, shown) in [(0.004, 0.0), (-0.004, 0.0), (0.006, 0.006), (-0.006, -0.006)] {
        let mut gyro = gyro(parameters.clone(), NAVIGATOR);
        close(&readings(&mut gyro, turning, &[1.0]), &[shown + 0.001], 1e-9);
    }
}

#[test]
fn fringes_are_a_sine_within_a_bell() {
    for celsius in [20.0, 26.0, 27.0, 33.0f64] {
        let parameters = GyroParameters {
            ambient_celsius: celsius,
            reference_celsius: 25.0,
            fringe_bias_deg_per_h: 3_600.0,
            fringe_period_kelvin: 4.0,
            fringe_width_kelvin: 6.0,
            ..Default::default()
        };
        let off = celsius - 25.0;
        let expected = (off * std::f64::consts::FRAC_PI_2).sin() * (-off * off / 72.0).exp();
        close(&at_rest(parameters, &[1.0]), &[expected], 1e-9);
    }
}

#[test]
fn a_temperature_coefficient_grows() {
    let parameters = GyroParameters {
        ambient_celsius: 35.0,
        reference_celsius: 25.0,
        drifting_bias_deg_per_h_per_kelvin: 360.0,
        drifting_time_constant_s: 100.0,
        ..Default::default()
    };
    let times = [1.0, 50.0, 100.0, 500.0];
    close(&at_rest(parameters, &times), &times.map(|t| 1.0 - (-t / 100.0).exp()), 2e-5);
}

#[test]
fn the_resonance_has_a_cusp() {
    let parameters = GyroParameters {
        resonance_ppm: 1_000.0,
        resonance_deg_per_s: 30.0,
        resonance_width_deg_per_s: 5.0,
        ..Default::default()
    };
    for (turning, ppm) in
        [(30.0, 1_000.0), (-30.0, 1_000.0), (25.0, 367.879), (-35.0, 367.879), (60.0, 2.4788)]
    {
        let mut gyro = gyro(parameters.clone(), NAVIGATOR);
        let shown = readings(&mut gyro, turning, &[1.0])[0];
        assert!(((shown / turning - 1.0) * 1e6 - ppm).abs() < 0.01, "{turning}: {shown}");
    }
}
