//! Effect of the terms on a heading.

use super::{Acts, Driver, Form, POWER_OFF_MIN, Point, TABLE_POINTS_MAX, TERMS_MAX, Term, Watch};
use crate::calibration::Calibration;
use proptest::prelude::*;
use std::vec::Vec;
use wire::time::{Span, Timestamp};
use wire::units::{Angle, AngularRate, Temperature};

fn term(acts: Acts, driver: Driver, form: Form) -> Term {
    Term { acts, driver, form, within: None, within_2: None }
}

fn at_s(seconds: f64) -> Timestamp {
    Timestamp::from_secs_f64(seconds)
}

/// Bias and scale of one term after `seconds` of temperatures.
fn after(term: Term, seconds: u32, celsius: fn(f64) -> f64, rate_deg_per_s: f64) -> (f64, f64) {
    let terms = [term].into_iter().collect();
    let mut watch = Watch::default();
    watch.begin(&terms);
    for second in 0..=seconds {
        let now = at_s(second.into());
        watch.hear(now);
        watch.tell(now, Temperature::from_celsius(celsius(second.into())), &terms);
    }
    let rate = rate_deg_per_s.to_radians();
    let sum = watch.sum(
        at_s(seconds.into()),
        &terms,
        rate,
        Angle::from_deg(90.0),
        AngularRate::from_rad_per_s(0.07),
        |_| 1.0,
    );
    (sum.bias, sum.scale - 1.0)
}

#[test]
fn each_driver_is_what_it_says() {
    let identity = Form::Linear { slope: 1e-6, origin: 0.0 };
    let ramp: fn(f64) -> f64 = |t| 20.0 + 0.01 * t;
    let up_and_down: fn(f64) -> f64 = |t| if t < 300.0 { 20.0 + 0.01 * t } else { 26.0 - 0.01 * t };
    let branch = Driver::TemperatureBranch { half_width_kelvin: 0.5 };
    let w = 30f64.to_radians();
    for (driver, celsius, expected) in [
        (Driver::Temperature, ramp, 26.0),
        (Driver::TemperatureRate, ramp, 0.01),
        // A lag L behind a ramp of slope r settles at r L.
        (Driver::TemperatureLag { time_constant_s: 50.0 }, ramp, 26.0 - 0.5),
        (branch, ramp, -0.5),
        (branch, up_and_down, 0.5),
        (Driver::Rate, ramp, -w),
        (Driver::AbsRate, ramp, w),
        (Driver::Direction, ramp, -1.0),
        (Driver::Heading, ramp, 90f64.to_radians()),
        (Driver::TestedBias, ramp, 0.07),
        (Driver::Time, ramp, 600.0),
        (Driver::Uptime, ramp, 600.0),
    ] {
        let (_, scale) = after(term(Acts::Scale, driver, identity.clone()), 600, celsius, -30.0);
        // A lag of 50 s sees steps of one second as half a second of age.
        assert!((scale * 1e6 - expected).abs() < 6e-3, "{driver:?}: {}", scale * 1e6);
    }
}

#[test]
fn beyond_its_range_a_term_stays_as_it_was_at_the_end() {
    let curve = Form::Quadratic { coefficient: 1e-6, origin: 20.0 };
    let curve = Term { within: Some([15.0, 30.0]), ..term(Acts::Bias, Driver::Temperature, curve) };
    for (celsius, expected) in [(25.0, 25e-6), (30.0, 100e-6), (70.0, 100e-6), (-10.0, 25e-6)] {
        let now: fn(f64) -> f64 = match celsius as i32 {
            25 => |_| 25.0,
            30 => |_| 30.0,
            70 => |_| 70.0,
            _ => |_| -10.0,
        };
        let (bias, _) = after(curve.clone(), 1, now, 0.0);
        assert!((bias - expected).abs() < 1e-12, "{celsius}: {bias}");
    }
    let product =
        Form::Product { coefficient: 1e-6, origin: 0.0, second: Driver::Time, origin_2: 0.0 };
    let product = Term {
        within: Some([0.0, 30.0]),
        within_2: Some([0.0, 10.0]),
        ..term(Acts::Bias, Driver::Temperature, product)
    };
    assert!((after(product.clone(), 5, |_| 20.0, 0.0).0 - 100e-6).abs() < 1e-12);
    assert!((after(product, 60, |_| 50.0, 0.0).0 - 300e-6).abs() < 1e-12);
    for range in [[30.0, 15.0], [f64::NAN, 1.0], [0.0, f64::INFINITY]] {
        assert!(!Term { within: Some(range), ..curve.clone() }.is_usable(), "{range:?}");
        assert!(!Term { within_2: Some(range), ..curve.clone() }.is_usable(), "{range:?}");
    }
}

#[test]
fn at_rest_there_is_no_direction() {
    let sign = term(Acts::Bias, Driver::Direction, Form::Linear { slope: 1e-3, origin: 0.0 });
    assert_eq!(after(sign, 1, |_| 20.0, 0.05), (0.0, 0.0));
}

#[test]
fn a_gyro_that_was_off_begins_anew_and_one_that_was_silent_goes_on() {
    let terms = [Driver::Time, Driver::Uptime]
        .map(|driver| term(Acts::Scale, driver, Form::Linear { slope: 1e-6, origin: 0.0 }));
    for (silence, time_s) in [(POWER_OFF_MIN, 105.0), (POWER_OFF_MIN + Span::from_secs(1), 0.0)] {
        let back = at_s(100.0) + silence;
        let mut watch = Watch::default();
        for second in 0..=100 {
            watch.hear(at_s(second.into()));
        }
        watch.hear(back);
        let found = terms.clone().map(|term| {
            let terms = [term].into_iter().collect();
            (watch.sum(back, &terms, 0.0, Angle::ZERO, AngularRate::ZERO, |_| 1.0).scale - 1.0)
                * 1e6
        });
        let uptime_s = (back - Timestamp::ZERO).as_secs_f64();
        assert!((found[0] - time_s).abs() < 1e-6 && (found[1] - uptime_s).abs() < 1e-6);
    }
}

#[test]
fn what_is_not_known_yet_corrects_nothing() {
    let of_slope = term(Acts::Bias, Driver::TemperatureRate, Form::Constant { value: 1e-3 });
    assert_eq!(after(of_slope, 5, |t| t, 0.0), (0.0, 0.0));
}

/// Correcting what a sensor with these terms reads gives the true rate.
#[test]
fn a_scale_over_the_rate_itself_is_undone() {
    let cubic =
        term(Acts::Scale, Driver::Rate, Form::Quadratic { coefficient: -0.02, origin: 0.0 });
    let offset = term(Acts::Bias, Driver::Direction, Form::Linear { slope: 1e-3, origin: 0.0 });
    let terms = [cubic, offset].into_iter().collect();
    let mut watch = Watch::default();
    watch.begin(&terms);
    for deg_per_s in [-90.0, -30.0, 5.0, 30.0, 90.0] {
        let w = AngularRate::from_deg_per_s(deg_per_s).rad_per_s();
        let read = w * (1.0 - 0.02 * w * w) + 1e-3 * w.signum();
        let sum = watch.sum(Timestamp::ZERO, &terms, read, Angle::ZERO, AngularRate::ZERO, |_| 1.0);
        let corrected = (read - sum.bias) / sum.scale;
        // The terms are up to 5 %, so that two iterations leave 0.05^3 and its slope of two.
        assert!((corrected / w - 1.0).abs() < 1e-3, "{deg_per_s}: {}", corrected / w - 1.0);
    }
}

#[test]
fn a_calibration_with_corrections_comes_back_from_its_text() {
    let text = r#"{"corrections":[
        {"acts":"bias","driver":"temperature_rate","form":{"linear":{"slope":0.0002,"origin":0.0}}},
        {"acts":"scale","driver":{"temperature_lag":{"time_constant_s":60.0}},
         "form":{"table":{"points":[{"x":20.0,"value":0.0},{"x":40.0,"value":0.01}]}}},
        {"acts":"scale","form":{"constant":{"value":-0.001}}}]}"#;
    let calibration: Calibration = serde_json::from_str(text).unwrap();
    assert!(calibration.is_usable() && calibration.corrections.len() == 3);
    let again = serde_json::to_string(&calibration).unwrap();
    assert_eq!(serde_json::from_str::<Calibration>(&again).unwrap(), calibration);
    let plain = serde_json::to_string(&Calibration::default()).unwrap();
    assert!(!plain.contains("corrections"), "{plain}");
    assert!(serde_json::from_str::<Calibration>(&text.replace("acts", "act")).is_err());
}

#[test]
fn a_term_of_nothing_is_not_usable() {
    let mut calibration = Calibration::default();
    let linear = Form::Linear { slope: 1.0, origin: 0.0 };
    calibration.corrections.push(term(Acts::Bias, Driver::None, linear)).unwrap();
    assert!(!calibration.is_usable());
    let still = Driver::TemperatureLag { time_constant_s: 0.0 };
    assert!(!term(Acts::Bias, still, Form::Constant { value: 0.0 }).is_usable());
}

fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![-1e3f64..1e3, any::<f64>()]
}

fn any_driver() -> impl Strategy<Value = Driver> {
    (0..12, any_number()).prop_map(|(which, number)| match which {
        0 => Driver::None,
        1 => Driver::Temperature,
        2 => Driver::TemperatureRate,
        3 => Driver::TemperatureLag { time_constant_s: number },
        4 => Driver::TemperatureBranch { half_width_kelvin: number },
        5 => Driver::Rate,
        6 => Driver::AbsRate,
        7 => Driver::Direction,
        8 => Driver::Heading,
        9 => Driver::Time,
        10 => Driver::TestedBias,
        _ => Driver::Uptime,
    })
}

fn any_form() -> impl Strategy<Value = Form> {
    let numbers = prop::array::uniform3(any_number());
    let points = prop::collection::vec((any_number(), any_number()), 0..=TABLE_POINTS_MAX);
    (0..13, numbers, points, any_driver()).prop_map(
        |(which, [a, b, c], points, second)| match which {
            0 => Form::Constant { value: a },
            1 => Form::Linear { slope: a, origin: b },
            2 => Form::Quadratic { coefficient: a, origin: b },
            3 => Form::Cubic { coefficient: a, origin: b },
            4 => Form::Exponential { amplitude: a, time_constant: b },
            5 => Form::Harmonic { order: 1, cos: a, sin: b },
            6 => Form::Periodic { cos: a, sin: b, period: c },
            7 => Form::Step { size: a, at: b },
            8 => Form::Hinge { slope: a, at: b },
            9 => Form::Bump { height: a, centre: b, width: c },
            10 => Form::Tanh { height: a, centre: b, width: c },
            11 => {
                let mut points: Vec<_> =
                    points.iter().map(|&(x, value)| Point { x, value }).collect();
                points.sort_by(|a, b| a.x.total_cmp(&b.x));
                Form::Table { points: points.into_iter().collect() }
            }
            _ => Form::Product { coefficient: a, origin: b, second, origin_2: c },
        },
    )
}

proptest! {
    #[test]
    fn finite_in_bounded_out(
        terms in prop::collection::vec((any::<bool>(), any_driver(), any_form()), 0..=TERMS_MAX),
        celsius in prop::collection::vec(-60f64..125.0, 1..30),
        rate in -4f64..4.0,
        heading in any_number(),
    ) {
        let terms = terms
            .into_iter()
            .map(|(bias, driver, form)| {
                term(if bias { Acts::Bias } else { Acts::Scale }, driver, form)
            })
            .filter(Term::is_usable)
            .collect();
        let mut watch = Watch::default();
        watch.begin(&terms);
        for (second, celsius) in celsius.iter().enumerate() {
            let now = at_s(second as f64);
            watch.hear(now);
            watch.tell(now, Temperature::from_celsius(*celsius), &terms);
            let sum = watch.sum(now, &terms, rate, Angle::from_rad(heading), AngularRate::ZERO, |_| 1.0);
            prop_assert!(sum.bias.abs() <= super::BIAS_SUM_MAX.rad_per_s());
            prop_assert!((sum.scale - 1.0).abs() <= super::SCALE_SUM_MAX);
        }
    }
}

/// A term with a memory that is loaded late has the state that it would have had from the beginning.
#[test]
fn what_is_loaded_late_has_the_same_memory() {
    let identity = Form::Linear { slope: 1e-6, origin: 0.0 };
    for driver in [
        Driver::TemperatureLag { time_constant_s: 300.0 },
        Driver::TemperatureBranch { half_width_kelvin: 2.0 },
    ] {
        let terms = [term(Acts::Bias, driver, identity.clone())].into_iter().collect();
        let (mut early, mut late) = (Watch::default(), Watch::default());
        early.begin(&terms);
        for second in 0..20_000_u32 {
            let now = at_s(second.into());
            let celsius = 30.0 + 10.0 * libm::sin(f64::from(second) / 1_000.0);
            for (watch, terms) in
                [(&mut early, &terms), (&mut late, &Vec::new().into_iter().collect())]
            {
                watch.hear(now);
                watch.tell(now, Temperature::from_celsius(celsius), terms);
            }
        }
        late.begin(&terms);
        let bias = |watch: &Watch| {
            let rest = (Angle::ZERO, AngularRate::ZERO);
            watch.sum(at_s(20_000.0), &terms, 0.0, rest.0, rest.1, |_| 1.0).bias
        };
        // In steps of 160 s, in which the temperature moves by 1.6 K at most.
        assert!((bias(&early) - bias(&late)).abs() < 0.7e-6, "{driver:?}");
    }
}
