//! A band of noise is no wave.

use crate::intervals::noise;
use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::finding::Finding;
use identification::identify::{Options, identify};
use std::f64::consts::TAU;

const SETS: u64 = 20;
const ROWS: usize = 3000;
/// Half the width of the band, and the wave, in cycles a row.
const WIDTH: f64 = 0.01;
const WAVE: f64 = 0.0731;

/// A gyro at rest for half a minute, with white noise, as much noise in a band, and a wave.
fn found(seed: u64, band: f64, wave: f64) -> Finding {
    let mut draw = noise(seed);
    let middle = 0.1 + 0.3 * seed as f64 / SETS as f64;
    let keep = (-TAU * WIDTH).exp();
    let (first, second) = (2.0 * keep * (TAU * middle).cos(), -keep * keep);
    // That of a second-order autoregression.
    let variance = (1.0 - second) / ((1.0 + second) * ((1.0 - second).powi(2) - first * first));
    let mut swings = [0.0; 2];
    let mut readings = Vec::new();
    for row in 0..2 * ROWS {
        swings = [first * swings[0] + second * swings[1] + draw(), swings[0]];
        let turns = wave * (TAU * WAVE * row as f64).sin();
        readings.push(0.02 * (draw() + band * swings[0] / variance.sqrt() + turns));
    }
    let times = (0..ROWS).map(|row| 0.01 * row as f64).collect();
    let rate = |name: &str, role, values| Column::new(name, role, Unit::DegreePerSecond, values);
    let columns = vec![
        Column::new("time", Role::Time, Unit::Second, times),
        rate("gyro", Role::GyroRate, readings.split_off(ROWS)),
        rate("reference", Role::ReferenceRate, vec![0.0; ROWS]),
    ];
    let dataset = Dataset::new("at_rest", Kind::Series, columns, vec![0; ROWS]);
    identify(&dataset, None, &Options::default(), &mut |_, _| ()).unwrap().finding
}

fn waves(finding: &Finding) -> usize {
    finding.effects.iter().filter(|effect| effect.form == "periodic").count()
}

/// One set in four had a wave: the largest of the band was measured against the noise of all frequencies.
#[test]
fn the_largest_wave_of_a_band_of_noise_is_no_effect() {
    let alarms = (0..SETS).filter(|seed| waves(&found(*seed, 1.0, 0.0)) > 0).count();
    assert_eq!(alarms, 0);
}

#[test]
fn a_wave_in_white_noise_is_one() {
    for seed in 0..6 {
        assert_eq!(waves(&found(seed, 0.0, 0.25)), 1, "{seed}");
    }
}
