//! A gyro against the heading of an angle encoder, which is read with it or now and then: what is found is what a reference rate
//! would show.

use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::identify::{Identified, Options, identify};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

const RUNS: usize = 4;
const ROWS: usize = 1500;
/// Time from row to row, s.
const DT: f64 = 0.01;
const BIAS: f64 = 0.5;
const LATE: f64 = 0.012;

/// Frequencies, 1/s, of what a hand does.
const TONES: [f64; 4] = [0.21, 0.47, 0.83, 1.31];

fn rate(t: f64) -> f64 {
    TONES.iter().map(|f| 25.0 * (TAU * f * t + 9.0 * f).sin()).sum()
}

fn heading(t: f64) -> f64 {
    TONES.iter().map(|f| -25.0 / (TAU * f) * (TAU * f * t + 9.0 * f).cos()).sum()
}

/// A gyro with this gain, in deg/s whatever its `unit`, beside a heading in each row or in one of `every`.
fn found(gain: f64, unit: Unit, every: usize) -> Identified {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(5);
    let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
    let (mut time, mut gyro, mut encoder, mut run_of_row) = (vec![], vec![], vec![], vec![]);
    for run in 0..RUNS {
        for row in 0..ROWS {
            let t = row as f64 * DT + 40.0 * run as f64;
            time.push(t);
            gyro.push(gain * rate(t - LATE) + BIAS + 0.3 * draw());
            let known = row % every == 0;
            encoder.push(if known { heading(t) + 0.03 * draw() } else { f64::NAN });
            run_of_row.push(run);
        }
    }
    let columns = vec![
        Column::new("time", Role::Time, Unit::Second, time),
        Column::new("gyro", Role::GyroRate, unit, gyro),
        Column::new("encoder", Role::ReferenceHeading, Unit::Degree, encoder),
    ];
    let dataset = Dataset::new("encoder", Kind::Series, columns, run_of_row);
    identify(&dataset, None, &Options::default(), &mut |_, _| ()).unwrap()
}

/// The first number of a term.
fn number(found: &Identified, name: &str) -> f64 {
    found.model.terms.iter().find(|term| term.name == name).unwrap().parameters[0].value
}

/// Its own rate in the place of the true one shares its noise and its delay, so neither the delay nor the scale showed.
#[test]
fn a_dense_heading_shows_a_scale_error_and_a_delay() {
    let found = found(0.97, Unit::DegreePerSecond, 1);
    // Motion as slow as this does not tell a delay from a low-pass.
    let [effect] = &found.finding.effects[..] else { panic!("{:?}", found.finding.effects) };
    assert_eq!(effect.term, "delay");
    assert!((effect.parameters[0].value - LATE).abs() < 1e-3, "{effect:?}");
    let scale = number(&found, "scale_factor");
    assert!((scale + 0.03).abs() < 3e-3, "{scale}");
}

#[test]
fn a_heading_shows_a_wrong_sign() {
    for every in [1, 50] {
        let found = found(-1.006, Unit::DegreePerSecond, every);
        let effects = &found.finding.effects;
        let names: Vec<&str> = effects.iter().map(|effect| effect.name.as_str()).collect();
        assert_eq!(names, ["reversed_sign", "delay"], "{effects:?}");
        let [delay, scale] = ["delay", "scale_factor"].map(|name| number(&found, name));
        assert!((delay - LATE).abs() < 2e-3, "{delay}");
        assert!((scale - 0.006).abs() < 5e-3, "{scale}");
    }
}

/// The gyro is far faster than its heading then: it was said that the heading does not move.
#[test]
fn a_heading_shows_degrees_for_radians() {
    for every in [1, 50] {
        let effects = found(0.994, Unit::RadianPerSecond, every).finding.effects;
        assert_eq!(effects[0].name, "degrees_for_radians", "{effects:?}");
    }
}

/// Nothing was compared, and it was said that nothing is missing.
#[test]
fn one_heading_in_each_run_is_refused() {
    let columns = vec![
        Column::new("time", Role::Time, Unit::Second, (0..40).map(f64::from).collect()),
        Column::new("gyro", Role::GyroRate, Unit::DegreePerSecond, vec![1.0; 40]),
        Column::new(
            "encoder",
            Role::ReferenceHeading,
            Unit::Degree,
            (0..40).map(|row| if row % 10 == 9 { f64::from(row) } else { f64::NAN }).collect(),
        ),
    ];
    let runs = (0..40).map(|row| row / 10).collect();
    let dataset = Dataset::new("ends", Kind::Series, columns, runs);
    let refused = identify(&dataset, None, &Options::default(), &mut |_, _| ()).unwrap_err();
    assert!(refused.to_string().contains("`encoder` has one value in each run"), "{refused}");
}
