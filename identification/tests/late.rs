//! A gyro that is late by some slow samples is reported as late, and noise far above the motion is not reported as an
//! error.

use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::finding::Finding;
use identification::identify::{Options, identify};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const RUNS: usize = 4;
const ROWS: usize = 900;
/// Delay, s, at one sample a second.
const LATE: f64 = 3.4;

/// Slow turns to and fro. The gyro reads the rate of `LATE` earlier, with that much noise (deg/s).
fn dataset(noise: f64, seed: u64) -> Dataset {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
    let (mut time, mut truth, mut reads) = (vec![], vec![], vec![]);
    for row in 0..RUNS * ROWS {
        let (run, at) = (row / ROWS, (row % ROWS) as f64);
        let rate = |at: f64| {
            let phase = at.max(0.0) + 40.0 * run as f64;
            3.0 * (phase / 17.0).sin() + 2.0 * (phase / 41.0).cos()
        };
        let drawn: f64 = StandardNormal.sample(&mut random);
        time.push(4000.0 * run as f64 + at);
        truth.push(rate(at));
        reads.push(0.1 + 1.002 * rate(at - LATE) + noise * drawn);
    }
    Dataset::new(
        "bench",
        Kind::Series,
        vec![
            Column::new("time", Role::Time, Unit::Second, time),
            Column::new("gyro", Role::GyroRate, Unit::DegreePerSecond, reads),
            Column::new("reference", Role::ReferenceRate, Unit::DegreePerSecond, truth),
        ],
        (0..RUNS * ROWS).map(|row| row / ROWS).collect(),
    )
}

fn found(noise: f64, seed: u64) -> Finding {
    identify(&dataset(noise, seed), None, &Options::default(), &mut |_, _| ()).unwrap().finding
}

#[test]
fn a_delay_of_some_slow_samples_is_a_delay() {
    for noise in [0.1, 1.0] {
        let finding = found(noise, 5);
        let names: Vec<&str> = finding.effects.iter().map(|one| one.name.as_str()).collect();
        assert_eq!(names, ["delay"], "{noise}");
        let late = &finding.effects[0].parameters[0];
        let error = late.standard_error.unwrap();
        assert!((late.value - LATE).abs() < 4.0 * error + 0.02, "{late:?}");
    }
}

#[test]
fn noise_far_above_the_motion_is_no_error() {
    for seed in 0..12 {
        let finding = found(200.0, seed);
        assert!(finding.effects.is_empty(), "{seed} {:?}", finding.effects);
    }
}

/// A sensor of any kind that is late by less than a sample, ten readings a second of a smooth motion: to first order its
/// error goes with the slope, and a line between samples is as wrong as the noise.
#[test]
fn a_late_sensor_is_late_and_no_more() {
    for (late, noise) in [(0.01, 0.002), (0.05, 0.002), (0.05, 0.05), (0.2, 0.002)] {
        let mut random = chacha20::ChaCha8Rng::seed_from_u64(8);
        let truth = |at: f64| (1.31 * at).sin() + 0.8 * (0.57 * at + 1.0).sin();
        let time: Vec<f64> = (0..2400).map(|row| 0.1 * f64::from(row)).collect();
        let read = |at: &f64| {
            let drawn: f64 = StandardNormal.sample(&mut random);
            0.01 + 1.002 * truth(at - late) + noise * drawn
        };
        let reads = time.iter().map(read).collect();
        let columns = vec![
            Column::new("gauge", Role::Measured, Unit::Volt, reads),
            Column::new(
                "truth",
                Role::Reference,
                Unit::Volt,
                time.iter().copied().map(truth).collect(),
            ),
            Column::new("time", Role::Time, Unit::Second, time),
        ];
        let run = (0..2400).map(|row| row / 400).collect();
        let dataset = Dataset::new("gauge", Kind::Sensor, columns, run);
        let finding =
            identify(&dataset, None, &Options::default(), &mut |_, _| ()).unwrap().finding;
        let names: Vec<&str> = finding.effects.iter().map(|one| one.name.as_str()).collect();
        assert_eq!(names, ["delay"], "{late} {noise} {:?}", finding.effects);
        let found = finding.effects[0].parameters[0].value;
        assert!((found - late).abs() < 0.002, "{late} {noise} {found}");
    }
}
