//! Error terms given in a device file.

use super::{NAVIGATOR, gyro, rate, run};
use crate::gyro::GyroParameters;
use crate::gyro::terms::{Acts, Driver, Form, Point, Term};
use crate::parameters::Parameters;
use wire::units::Angle;

/// Contribution of one term to the reading at 200 s, rad/s, on a coil that warms from 20 degC by 10 K with a time
/// constant of 100 s while the carrier turns at -30 deg/s.
fn adds(driver: Driver, form: Form) -> f64 {
    of_term(Term { acts: Acts::Bias, driver, form, within: None, within_2: None })
}

fn of_term(term: Term) -> f64 {
    let parameters = GyroParameters {
        ambient_celsius: 20.0,
        self_heating_kelvin: 10.0,
        thermal_time_constant_s: 100.0,
        terms: vec![term],
        ..Default::default()
    };
    let mut last = f64::NAN;
    run(
        &mut gyro(parameters, NAVIGATOR),
        200.0,
        |t| Angle::from_deg(-30.0 * t),
        |sample| {
            last = rate(sample);
        },
    );
    (last + 30.0).to_radians()
}

#[test]
fn each_driver_is_what_is_true() {
    let identity = Form::Linear { slope: 1.0, origin: 0.0 };
    let left = 10.0 * (-2f64).exp();
    let heading = (-30.0f64 * 200.0).to_radians();
    for (driver, expected, within) in [
        (Driver::Temperature, 30.0 - left, 1e-3),
        (Driver::TemperatureRate, left / 100.0, 1e-3),
        // Applied to e^(-t/100), a lag of 50 s gives 2 e^(-t/100) - e^(-t/50).
        (
            Driver::TemperatureLag { time_constant_s: 50.0 },
            30.0 - 10.0 * (2.0 * (-2f64).exp() - (-4f64).exp()),
            0.05,
        ),
        (Driver::TemperatureBranch { half_width_kelvin: 3.0 }, -3.0, 1e-3),
        (Driver::Rate, -30f64.to_radians(), 1e-6),
        (Driver::AbsRate, 30f64.to_radians(), 1e-6),
        (Driver::Direction, -1.0, 1e-6),
        (Driver::Heading, heading, 0.01),
        (Driver::Time, 200.0, 0.02),
    ] {
        let found = adds(driver, identity.clone());
        assert!((found - expected).abs() < within, "{driver:?}: {found} is not {expected}");
    }
}

#[test]
fn each_form_is_its_formula() {
    let w = 30f64.to_radians();
    let points = vec![Point { x: 0.0, value: 1.0 }, Point { x: 2.0 * w, value: 3.0 }];
    let left = 10.0 * (-2f64).exp();
    for (form, expected) in [
        (Form::Constant { value: 0.5 }, 0.5),
        (Form::Linear { slope: 2.0, origin: 0.1 }, 2.0 * (w - 0.1)),
        (Form::Quadratic { coefficient: 2.0, origin: 0.1 }, 2.0 * (w - 0.1).powi(2)),
        (Form::Cubic { coefficient: 2.0, origin: 1.0 }, 2.0 * (w - 1.0).powi(3)),
        (Form::Exponential { amplitude: 2.0, time_constant: w }, 2.0 * (-1f64).exp()),
        (Form::Harmonic { order: 2, cos: 1.0, sin: 3.0 }, (2.0 * w).cos() + 3.0 * (2.0 * w).sin()),
        (Form::Periodic { cos: 1.0, sin: 3.0, period: 4.0 * w }, 3.0),
        (Form::Step { size: 2.0, at: 0.5 }, 2.0),
        (Form::Step { size: 2.0, at: 0.6 }, 0.0),
        (Form::Hinge { slope: 2.0, at: 0.5 }, 2.0 * (w - 0.5)),
        (Form::Hinge { slope: 2.0, at: 0.6 }, 0.0),
        (Form::Bump { height: 2.0, centre: 0.0, width: w }, 2.0 * (-0.5f64).exp()),
        (Form::Tanh { height: 2.0, centre: 0.0, width: w }, 2.0 * 1f64.tanh()),
        (Form::Table { points }, 2.0),
        (
            Form::Product {
                coefficient: 2.0,
                origin: 0.1,
                second: Driver::Temperature,
                origin_2: 25.0,
            },
            2.0 * (w - 0.1) * (5.0 - left),
        ),
    ] {
        let found = adds(Driver::AbsRate, form.clone());
        assert!((found - expected).abs() < 1e-3, "{form:?}: {found} is not {expected}");
    }
}

#[test]
fn beyond_its_range_a_term_stays_as_it_was_at_the_end() {
    let line = |within| Term {
        acts: Acts::Bias,
        driver: Driver::AbsRate,
        form: Form::Linear { slope: 1.0, origin: 0.0 },
        within: Some(within),
        within_2: None,
    };
    let w = 30f64.to_radians();
    for (within, expected) in [([0.0, 1.0], w), ([0.0, 0.25], 0.25), ([0.75, 1.0], 0.75)] {
        let found = of_term(line(within));
        assert!((found - expected).abs() < 1e-6, "{within:?}: {found} is not {expected}");
    }
    for within in [[1.0, 0.0], [f64::NAN, 1.0]] {
        assert!(line(within).check().is_err(), "{within:?}");
    }
}

#[test]
fn a_scale_term_multiplies_and_sees_no_temperature_sensor() {
    let term = Term {
        acts: Acts::Scale,
        driver: Driver::Temperature,
        form: Form::Linear { slope: 1e-4, origin: 20.0 },
        within: None,
        within_2: None,
    };
    let parameters = GyroParameters {
        ambient_celsius: 30.0,
        temperature_offset_kelvin: 5.0,
        terms: vec![term],
        ..Default::default()
    };
    let mut gyro = gyro(parameters, NAVIGATOR);
    let mut last = 0.0;
    run(&mut gyro, 2.0, |t| Angle::from_deg(10.0 * t), |sample| last = rate(sample));
    assert!((last - 10.0 * 1.001).abs() < 1e-9);
    gyro.set_parameter("terms.0.slope", 2e-4).unwrap();
    run(&mut gyro, 4.0, |t| Angle::from_deg(10.0 * t), |sample| last = rate(sample));
    assert!((last - 10.0 * 1.002).abs() < 1e-9, "{last}");
    assert!((gyro.truth().scale - 1.002).abs() < 1e-12);
}
