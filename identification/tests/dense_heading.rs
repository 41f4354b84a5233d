//! A gyro against the heading of an angle encoder, which is read with it or now and then: what is found is what a reference rate
//! would show.

use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::finding::Effect;
use identification::identify::{Identified, Options, identify};
use identification::model::Term;
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

/// A gyro in deg/s whatever its `unit`, beside a heading.
#[derive(Clone, Copy)]
struct Recording {
    gain: f64,
    unit: Unit,
    /// How late the gyro is, s.
    late: f64,
    /// Times the motion is that of a hand.
    size: f64,
    /// Rows from heading to heading.
    every: usize,
    /// Standard deviation of the heading, deg.
    noise: f64,
    /// Step of the encoder, deg.
    step: Option<f64>,
}

const PLAIN: Recording = Recording {
    gain: 1.006,
    unit: Unit::DegreePerSecond,
    late: 0.0,
    size: 1.0,
    every: 1,
    noise: 0.03,
    step: None,
};

impl Recording {
    fn found(self) -> Identified {
        let mut random = chacha20::ChaCha8Rng::seed_from_u64(5);
        let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
        let (mut time, mut gyro, mut encoder, mut run_of_row) = (vec![], vec![], vec![], vec![]);
        for run in 0..RUNS {
            for row in 0..ROWS {
                let t = row as f64 * DT + 40.0 * run as f64;
                time.push(t);
                gyro.push(self.gain * self.size * rate(t - self.late) + BIAS + 0.3 * draw());
                let known = row % self.every == 0;
                let angle = if known { self.size * heading(t) } else { f64::NAN };
                let angle = if known { angle + self.noise * draw() } else { angle };
                encoder.push(self.step.map_or(angle, |step| (angle / step).round() * step));
                run_of_row.push(run);
            }
        }
        let columns = vec![
            Column::new("time", Role::Time, Unit::Second, time),
            Column::new("gyro", Role::GyroRate, self.unit, gyro),
            Column::new("encoder", Role::ReferenceHeading, Unit::Degree, encoder),
        ];
        let dataset = Dataset::new("encoder", Kind::Series, columns, run_of_row);
        identify(&dataset, None, &Options::default(), &mut |_, _| ()).unwrap()
    }
}

/// A late gyro with this gain, in deg/s whatever its `unit`, beside a heading in each row or in one of `every`.
fn found(gain: f64, unit: Unit, every: usize) -> Identified {
    Recording { gain, unit, every, late: LATE, ..PLAIN }.found()
}

/// The first number of an effect, by its term.
fn number(found: &Identified, term: &str) -> f64 {
    let is_it = |one: &&Effect| one.term == term;
    found.finding.effects.iter().rfind(is_it).unwrap().parameters[0].value
}

/// The scale factor and its standard error.
fn scale(found: &Identified) -> [f64; 2] {
    let number = |one: &Term| [one.parameters[0].value, one.parameters[0].standard_error.unwrap()];
    found.model.terms.iter().find(|one| one.name == "scale_factor").map(number).unwrap()
}

/// Its own rate in the place of the true one shares its noise and its delay, so neither the delay nor the scale showed.
#[test]
fn a_dense_heading_shows_a_scale_error_and_a_delay() {
    let found = found(0.97, Unit::DegreePerSecond, 1);
    // Motion as slow as this does not tell a delay from a low-pass.
    let [effect] = &found.finding.effects[..] else { panic!("{:?}", found.finding.effects) };
    assert_eq!(effect.term, "delay");
    assert!((effect.parameters[0].value - LATE).abs() < 1e-3, "{effect:?}");
    let [scale, _] = scale(&found);
    assert!((scale + 0.03).abs() < 3e-3, "{scale}");
}

#[test]
fn a_heading_shows_a_wrong_sign() {
    for every in [1, 50] {
        let found = found(-1.006, Unit::DegreePerSecond, every);
        let effects = &found.finding.effects;
        let terms: Vec<&str> = effects.iter().map(|effect| effect.term.as_str()).collect();
        assert_eq!(terms, ["scale", "delay"], "{effects:?}");
        assert_eq!(effects[0].name, "reversed_sign");
        let ([scale, _], delay) = (scale(&found), number(&found, "delay"));
        assert!((delay - LATE).abs() < 2e-3, "{delay}");
        assert!((scale - 0.006).abs() < 5e-3, "{scale}");
    }
}

/// The noise of the headings was in the true turn as well as in the error, and that of the gyro in the rotation as well: a scale
/// of -1 took all of the one away and a knee all of the other. A base scale of up to -0.06 was that of a dense heading.
#[test]
fn noise_of_a_heading_is_no_scale_error_and_no_knee() {
    for every in [1, 20] {
        for (size, noise) in [(0.2, 2.0), (0.04, 0.5)] {
            let found = Recording { size, noise, every, ..PLAIN }.found();
            let [scale, error] = scale(&found);
            assert!((scale - 0.006).abs() < 3.0 * error, "{every} {size} {noise}: {scale} {error}");
            let effects = &found.finding.effects;
            assert!(effects.is_empty(), "{every} {size} {noise}: {effects:?}");
        }
    }
}

/// Between two steps of an encoder the heading stands still and the gyro does not: that was a scale error of up to -1.1.
#[test]
fn a_coarse_encoder_says_the_angle_where_it_steps() {
    for (size, step) in [(0.2, 1.0), (0.04, 0.1)] {
        for late in [0.0, 0.02] {
            let recording = Recording { size, late, noise: 0.0, step: Some(step), ..PLAIN };
            let found = recording.found();
            let [scale, error] = scale(&found);
            assert!((scale - 0.006).abs() < 4.0 * error, "{size} {step}: {scale} {error}");
            let terms: Vec<&str> =
                found.finding.effects.iter().map(|effect| effect.term.as_str()).collect();
            assert_eq!(terms.as_slice(), if late > 0.0 { &["delay"][..] } else { &[] });
            if late > 0.0 {
                let delay = number(&found, "delay");
                assert!((delay - late).abs() < 3e-3, "{size} {step}: {delay}");
            }
        }
    }
}

/// Delays were added up over rows from their ends, half a row late, and between sparse headings the gyro itself told the course: a
/// scale of +0.006 came out as -0.017 and as +0.085, and a delay of 100 ms as one of 101 ms and of 81 ms. A coarse encoder still takes
/// some of the scale.
#[test]
fn a_long_delay_leaves_the_scale_alone() {
    for (noise, every, step) in [(0.03, 1, None), (0.5, 20, None), (0.0, 1, Some(1.0))] {
        let found = Recording { late: 0.1, noise, every, step, ..PLAIN }.found();
        let (delay, [scale, error]) = (number(&found, "delay"), scale(&found));
        assert!((delay - 0.1).abs() < if every > 1 { 3e-3 } else { 7e-4 }, "{every}: {delay}");
        let off = (scale - 0.006).abs();
        let most = if step.is_some() { 4e-3 } else { 1.5e-3 };
        assert!(off < most || off < 4.0 * error, "{every} {step:?}: {scale} {error}");
    }
}

/// The first readings of a late gyro are of motion before the record, so the error of the angle grew from there on.
#[test]
fn the_error_of_the_angle_falls_with_a_long_delay() {
    let found = Recording { late: 0.1, ..PLAIN }.found();
    let held_out = &found.finding.held_out;
    assert!(held_out.after < 0.05 * held_out.before, "{held_out:?}");
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
