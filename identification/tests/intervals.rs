//! Stated errors hold: those of numbers that a model is not linear in as well, and of thresholds.

use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::finding::{Finding, Parameter};
use identification::identify::{Options, identify};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

/// Number of sets, and of those whose intervals must hold: fewer than ten hold in one of 80 times, where 95 % do.
pub const SETS: u64 = 12;
const HELD: usize = 10;

pub fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
    move || StandardNormal.sample(&mut random)
}

/// Readings of a sensor beside their reference, in four runs.
fn found(dt: f64, readings: Vec<f64>, truth: Vec<f64>) -> Finding {
    let rows = truth.len();
    let times = (0..rows).map(|row| row as f64 * dt).collect();
    let columns = vec![
        Column::new("time", Role::Time, Unit::Second, times),
        Column::new("reading", Role::Measured, Unit::Volt, readings),
        Column::new("truth", Role::Reference, Unit::Volt, truth),
    ];
    let run = (0..rows).map(|row| row * 4 / rows).collect();
    let dataset = Dataset::new("intervals", Kind::Sensor, columns, run);
    identify(&dataset, None, &Options::default(), &mut |_, _| ()).unwrap().finding
}

pub fn parameter<'a>(finding: &'a Finding, effect: &str, name: &str) -> &'a Parameter {
    let effect = finding.effects.iter().find(|one| one.name == effect).unwrap();
    effect.parameters.iter().find(|one| one.name == name).unwrap()
}

/// Asserts that intervals of two standard errors hold the true values, in most sets, and are no wider than `most`.
pub fn assert_held(all: &[(f64, &Parameter)], most: f64) {
    let errors: Vec<f64> = all.iter().map(|(_, one)| one.standard_error.unwrap()).collect();
    assert!(errors.iter().all(|error| *error < most), "{errors:?}");
    let off = all.iter().zip(&errors).map(|((value, one), error)| (one.value - value) / error);
    let off: Vec<f64> = off.collect();
    assert!(off.iter().filter(|off| off.abs() < 1.96).count() >= HELD, "{off:?}");
}

/// The least error is the noise over the root of the sum of the squared slopes (Cramer and Rao). Where the delay could be
/// another than what is late of it, its error was six times as large, and it was four of those off.
#[test]
fn a_delay_is_as_certain_as_the_readings_allow() {
    let tones = [[8.0, 0.13, 0.3], [5.0, 0.41, 2.0], [3.0, 0.9, 4.0]];
    let truth = |t: f64| tones.iter().map(|[a, f, p]| a * (TAU * f * t + p).sin()).sum::<f64>();
    let slope =
        |t: f64| tones.iter().map(|[a, f, p]| TAU * f * a * (TAU * f * t + p).cos()).sum::<f64>();
    let times: Vec<f64> = (0..2000).map(|row| f64::from(row) * 0.05).collect();
    let squares: f64 = times.iter().map(|t| slope(*t).powi(2)).sum();
    let least = 0.1 / squares.sqrt();
    let findings: Vec<(f64, Finding)> = (0..SETS)
        .map(|seed| {
            let (by, mut draw) = (0.13 + 0.03 * seed as f64, noise(900 + seed));
            let readings = times.iter().map(|t| 1.02 * truth(t - by) + 0.3 + 0.1 * draw());
            (by, found(0.05, readings.collect(), times.iter().map(|t| truth(*t)).collect()))
        })
        .collect();
    let all: Vec<(f64, &Parameter)> =
        findings.iter().map(|(by, finding)| (*by, parameter(finding, "delay", "delay"))).collect();
    assert_held(&all, 1.3 * least);
}

/// A jump of twice the noise is not seen to the row.
#[test]
fn the_time_of_a_step_is_as_certain_as_its_size_allows() {
    let findings: Vec<(f64, Finding)> = (0..SETS)
        .map(|seed| {
            let (at, mut draw) = (731.0 + 97.0 * seed as f64, noise(700 + seed));
            let truth: Vec<f64> =
                (0..2400).map(|row| 5.0 * (f64::from(row) / 37.0).sin()).collect();
            let late = |row: usize| if row as f64 > at { 0.1 } else { 0.0 };
            let readings = truth.iter().enumerate().map(|(row, x)| x + late(row) + 0.1 * draw());
            (at + 0.5, found(1.0, readings.collect(), truth.clone()))
        })
        .collect();
    let all: Vec<(f64, &Parameter)> =
        findings.iter().map(|(at, finding)| (*at, parameter(finding, "bias_step", "at"))).collect();
    assert_held(&all, 8.0);
}

/// Readings beside a width that was not yet right counted as outliers, and it stayed.
#[test]
fn the_width_of_a_dead_zone_lies_between_two_readings() {
    let findings: Vec<(f64, Finding)> = (0..SETS)
        .map(|seed| {
            let (width, mut draw) = (1.1 + 0.13 * seed as f64, noise(500 + seed));
            let course = |t: f64| 9.0 * (t / 37.0).sin() + 6.0 * (t / 11.3).cos();
            let truth: Vec<f64> = (0..3000).map(|row| course(f64::from(row))).collect();
            let seen = |x: &f64| if x.abs() < width { 0.0 } else { *x };
            let readings = truth.iter().map(|x| seen(x) + 0.2 + 0.1 * draw()).collect();
            (width, found(1.0, readings, truth.clone()))
        })
        .collect();
    let all: Vec<(f64, &Parameter)> = findings
        .iter()
        .map(|(width, finding)| (*width, parameter(finding, "dead_zone", "width")))
        .collect();
    assert_held(&all, 0.05);
}
