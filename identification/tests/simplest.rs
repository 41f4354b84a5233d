//! A cause without a number of its own, such as a time constant, goes before the same with one that hardly pays.

use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::finding::Finding;
use identification::identify::{Options, identify};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const RUNS: usize = 7;
const ROWS: usize = 500;
/// Noise of a reading at rest.
const NOISE: f64 = 0.006;
/// Noise of the thermometer beside it, K.
const BESIDE: f64 = 0.1;
const SLOPE: f64 = -0.1;
const MIDDLE: f64 = 30.0;

/// A sensor whose readings are noisier the faster its reference moves, which no noise knows, and whose bias follows what
/// `felt` makes of the temperature of each run. The thermometer has noise too, and any lag evens that out.
fn found(felt: impl Fn(&[f64]) -> Vec<f64>) -> Finding {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(4);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let (mut time, mut reads, mut truth, mut beside) = (vec![], vec![], vec![], vec![]);
    for run in 0..RUNS {
        let phase = run as f64;
        let period = 90.0 + 7.0 * phase;
        let at = |row: usize| 2.0 * row as f64;
        let warm =
            |row: usize| MIDDLE + 1.5 * (1.7 * phase).sin() + 1.2 * (at(row) / 260.0 + phase).sin();
        let warmth: Vec<f64> = (0..ROWS).map(warm).collect();
        for (row, felt) in felt(&warmth).into_iter().enumerate() {
            let turn = at(row) / period + phase;
            let speed = 4.0 / period * turn.cos();
            let noise = NOISE * (1.0 + 250.0 * speed.abs()) * normal();
            time.push(at(row));
            truth.push(4.0 * turn.sin());
            reads.push(4.0 * turn.sin() + SLOPE * (felt - MIDDLE) + noise);
            beside.push(warmth[row] + BESIDE * normal());
        }
    }
    let columns = vec![
        Column::new("time", Role::Time, Unit::Second, time),
        Column::new("reads", Role::Measured, Unit::One, reads),
        Column::new("truth", Role::Reference, Unit::One, truth),
        Column::new("beside", Role::Temperature, Unit::Celsius, beside),
    ];
    let run = (0..RUNS * ROWS).map(|row| row / ROWS).collect();
    let dataset = Dataset::new("noisier when fast", Kind::Sensor, columns, run);
    identify(&dataset, None, &Options::default(), &mut |_, _| ()).unwrap().finding
}

#[test]
fn a_lag_that_only_evens_out_a_noisy_thermometer_is_a_rival() {
    let finding = found(<[f64]>::to_vec);
    let [effect] = &finding.effects[..] else { panic!("{:?}", finding.effects) };
    assert_eq!(effect.name, "bias_over_temperature", "{:?}", finding.path);
    assert!((effect.parameters[0].value - SLOPE).abs() < 0.005, "{:?}", effect.parameters);
    let is_lag = |name: &str| name == "bias_temperature_lag";
    assert!(effect.rivals.iter().any(|rival| is_lag(&rival.name)), "{:?}", effect.rivals);
}

#[test]
fn a_lag_that_pays_is_named() {
    const LAG_S: f64 = 120.0;
    let lagged = |warmth: &[f64]| {
        let (keep, mut state) = ((-2.0 / LAG_S).exp(), warmth[0]);
        let next = |warm: &f64| {
            state = keep * state + (1.0 - keep) * warm;
            state
        };
        warmth.iter().map(next).collect()
    };
    let finding = found(lagged);
    let [effect] = &finding.effects[..] else { panic!("{:?}", finding.effects) };
    assert_eq!(effect.name, "bias_temperature_lag", "{:?}", finding.path);
}
