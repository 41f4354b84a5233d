//! Rounding that is coarser than the noise stands among the effects, with its step.

use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::finding::Finding;
use identification::identify::{Options, identify};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use std::collections::BTreeMap;

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
    let column = |name: &str, role, unit, values| Column {
        name: name.to_owned(),
        role,
        axis: None,
        unit,
        values,
    };
    let dataset = Dataset {
        name: "bench".to_owned(),
        kind: Kind::Series,
        drive: None,
        constants: BTreeMap::new(),
        columns: vec![
            column("time", Role::Time, Unit::Second, time),
            column("gyro", Role::GyroRate, Unit::DegreePerSecond, gyro),
            column("table", Role::ReferenceRate, Unit::DegreePerSecond, rate),
        ],
        run_of_row: vec![0; ROWS],
        run_labels: vec!["0".to_owned()],
        notices: Vec::new(),
    };
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
