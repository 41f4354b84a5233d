//! Rounding coarser than the noise appears among the effects, with its step.

use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::finding::Finding;
use identification::identify::{Options, identify};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const ROWS: usize = 2400;
const SIGMA: f64 = 0.02;

/// Forty minutes of a gyro on a table at 1 Hz, read in steps.
fn found(step: f64, seed: u64) -> Finding {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let time: Vec<f64> = (0..ROWS).map(|row| row as f64).collect();
    let rate: Vec<f64> = time.iter().map(|t| 20.0 * (t / 37.0).sin()).collect();
    let gyro = rate
        .iter()
        .map(|rate| {
            let reading = 1.002 * rate + 0.1 + SIGMA * normal();
            if step > 0.0 { (reading / step).round() * step } else { reading }
        })
        .collect();
    let dataset = Dataset::new(
        "bench",
        Kind::Series,
        vec![
            Column::new("time", Role::Time, Unit::Second, time),
            Column::new("gyro", Role::GyroRate, Unit::DegreePerSecond, gyro),
            Column::new("table", Role::ReferenceRate, Unit::DegreePerSecond, rate),
        ],
        vec![0; ROWS],
    );
    identify(&dataset, None, &Options::default(), &mut |_, _| ()).expect("whole data").finding
}

fn terms(finding: &Finding) -> Vec<&str> {
    finding.effects.iter().map(|effect| effect.term.as_str()).collect()
}

#[test]
fn rounding_is_named_with_its_step() {
    let finding = found(0.05, 5);
    assert_eq!(terms(&finding), ["quantisation"]);
    let step = &finding.effects[0].parameters[0];
    assert!((step.value - 0.05).abs() < 1e-4 && step.unit == "deg/s", "{step:?}");
}

#[test]
fn fine_readings_are_not_rounded() {
    for seed in 0..4 {
        assert!(terms(&found(0.0, seed)).is_empty(), "{seed}");
    }
}
