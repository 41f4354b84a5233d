//! Samples in, heading out.

use super::{HeadingIntegrator, IntegrationClock};
use crate::calibration::{Calibration, Factor};
use crate::config::GyroConfig;
use crate::correction::{Acts, Driver, Form, Term};
use proptest::prelude::*;
use wire::gyro::{GyroOutput, GyroSample, GyroStatus, Sequence};
use wire::time::{Span, Timestamp};
use wire::units::{Angle, AngularRate, Temperature};

const PERIOD: Span = Span::from_millis(10);

fn sample(output: GyroOutput, number: u32) -> GyroSample {
    GyroSample {
        output,
        valid: true,
        status: GyroStatus::default(),
        temperature: Some(Temperature::from_celsius(25.0)),
        sequence: Some(Sequence { value: number as u8, modulus: 256 }),
    }
}

fn at(n: u32) -> Timestamp {
    Timestamp::ZERO + PERIOD * i64::from(n)
}

/// Angle at sample `n`: one turn in 12 s, in any format.
fn turn(n: u32) -> Angle {
    Angle::from_deg(360.0 / 1_200.0 * f64::from(n))
}

#[test]
fn rate_increment_and_integrated_angle_agree() {
    let rate = turn(1) / PERIOD;
    type Form = (&'static str, fn(u32, AngularRate) -> GyroOutput);
    let forms: [Form; 3] = [
        ("rate", |_, rate| GyroOutput::Rate(rate)),
        ("increment", |_, _| GyroOutput::Increment(turn(1))),
        ("integrated", |n, _| GyroOutput::Integrated(turn(n).wrapped())),
    ];
    for (name, form) in forms {
        let mut integrator = HeadingIntegrator::new(&GyroConfig::default());
        // The first integrated angle is the origin.
        integrator.sample(at(0), &sample(form(0, AngularRate::ZERO), 0), 0);
        integrator.set_heading(Angle::ZERO);
        for n in 1..=1_200 {
            integrator.sample(at(n), &sample(form(n, rate), n), 0);
        }
        assert!((integrator.heading().deg() - 360.0).abs() < 1e-9, "{name}");
    }
}

#[test]
fn bias_and_factors_are_those_of_eq_4() {
    let mut integrator = HeadingIntegrator::new(&GyroConfig::default());
    integrator.set_bias(AngularRate::from_deg_per_s(0.1));
    let line = Factor::TemperatureLine { slope_deg_per_celsius: -0.52, intercept_deg: 19.23 };
    integrator.set_calibration(Calibration {
        factors: [line].into_iter().collect(),
        ..Calibration::default()
    });
    for n in 0..1_000 {
        let output = GyroOutput::Rate(AngularRate::from_deg_per_s(30.1));
        integrator.sample(at(n), &sample(output, n), 0);
    }
    let expected = 300.0 * 360.0 / (379.23 - 0.52 * 25.0);
    assert!((integrator.heading().deg() - expected).abs() < 1e-9);
}

/// Half of the tested bias is noise: half of it is removed, and a new test starts from the raw rate, not from the old
/// bias.
#[test]
fn a_correction_over_the_tested_bias_leaves_the_next_test_alone() {
    let mut integrator = HeadingIntegrator::new(&GyroConfig::default());
    let half = Term {
        acts: Acts::Bias,
        driver: Driver::TestedBias,
        form: Form::Linear { slope: -0.5, origin: 0.0 },
        within: None,
        within_2: None,
    };
    integrator.set_calibration(Calibration {
        corrections: [half].into_iter().collect(),
        ..Calibration::default()
    });
    integrator.set_bias(AngularRate::from_deg_per_s(0.2));
    let output = GyroOutput::Rate(AngularRate::from_deg_per_s(0.1));
    let mut seen = AngularRate::ZERO;
    for n in 0..100 {
        seen = integrator.sample(at(n), &sample(output, n), 0).raw_rate;
    }
    assert!((seen.deg_per_s() - 0.1).abs() < 1e-12, "{seen:?}");
    assert!(integrator.heading().deg().abs() < 1e-12, "{:?}", integrator.heading());
}

#[test]
fn a_held_heading_stays_and_the_samples_count_on() {
    let mut integrator = HeadingIntegrator::new(&GyroConfig::default());
    let output = GyroOutput::Rate(AngularRate::from_deg_per_s(0.01));
    integrator.hold(true);
    for n in 0..100 {
        integrator.sample(at(n), &sample(output, n), 0);
    }
    assert_eq!((integrator.heading(), integrator.samples()), (Angle::ZERO, 100));
    integrator.hold(false);
    integrator.sample(at(100), &sample(output, 100), 0);
    assert!(integrator.heading() > Angle::ZERO);
}

#[test]
fn silence_is_not_bridged() {
    let mut integrator = HeadingIntegrator::new(&GyroConfig::default());
    let output = GyroOutput::Rate(AngularRate::from_deg_per_s(10.0));
    integrator.sample(at(0), &sample(output, 0), 0);
    let reading = integrator.sample(at(500), &sample(output, 244), 0);
    assert!(reading.lost == 0 && reading.after_silence);
    assert!((integrator.heading().deg() - 0.2).abs() < 1e-9);
}

/// Half a second and three seconds without a gyro, with and without numbers, which wrap.
#[test]
fn what_a_silence_lost_is_counted() {
    for (back, lost) in [(150, 49), (400, 299)] {
        for numbered in [true, false] {
            let mut integrator = HeadingIntegrator::new(&GyroConfig::default());
            for n in (0..=100).chain(back..back + 10) {
                let mut sample = sample(GyroOutput::Rate(AngularRate::ZERO), n);
                sample.sequence = sample.sequence.filter(|_| numbered);
                integrator.sample(at(n), &sample, 0);
            }
            assert_eq!(integrator.samples_lost(), lost, "{numbered}");
        }
    }
}

#[test]
fn host_time_follows_a_slow_gyro_and_sample_count_does_not() {
    for (clock, expected) in [(IntegrationClock::Samples, 30.0), (IntegrationClock::HostTime, 30.9)]
    {
        let config = GyroConfig { clock, ..GyroConfig::default() };
        let mut integrator = HeadingIntegrator::new(&config);
        let rate = GyroOutput::Rate(AngularRate::from_deg_per_s(3.0));
        for n in 0..1_000 {
            let arrival = Timestamp::ZERO + Span::from_micros(10_300) * i64::from(n);
            integrator.sample(arrival, &sample(rate, n), 0);
        }
        assert!((integrator.heading().deg() - expected).abs() < 0.01, "{clock:?}");
    }
}

#[test]
fn a_number_that_repeats_or_leaps_is_not_bridged() {
    let rate = GyroOutput::Rate(AngularRate::from_deg_per_s(30.0));
    let mut integrator = HeadingIntegrator::new(&GyroConfig::default());
    integrator.sample(at(0), &sample(rate, 0), 0);
    integrator.sample(at(1), &sample(rate, 1), 0);
    integrator.sample(at(1), &sample(rate, 1), 0);
    assert!((integrator.heading().deg() - 0.6).abs() < 1e-9, "doubled");
    integrator.sample(at(2), &sample(rate, 200), 0);
    integrator.sample(at(3), &sample(rate, 3), 0);
    assert!((integrator.heading().deg() - 1.2).abs() < 1e-9, "leapt and back");
    assert_eq!((integrator.samples(), integrator.samples_lost()), (4, 0));
}

proptest! {
    #[test]
    fn lost_samples_are_bridged_and_counted(lost in prop::collection::btree_set(2u32..998, 0..200)) {
        let mut integrator = HeadingIntegrator::new(&GyroConfig::default());
        // A ramp: the mean of the neighbours is exact when one sample is lost.
        let rate = |n: u32| AngularRate::from_deg_per_s(0.03 * f64::from(n));
        for n in (0..1_000).filter(|n| !lost.contains(n)) {
            integrator.sample(at(n), &sample(GyroOutput::Rate(rate(n)), n), 0);
        }
        let ideal: f64 = (0..1_000).map(|n| rate(n).deg_per_s() * 0.01).sum();
        prop_assert_eq!(integrator.samples_lost(), lost.len() as u64);
        prop_assert!((integrator.heading().deg() - ideal).abs() < 0.05);
    }
}
