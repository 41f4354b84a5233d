//! Nothing is wrong with a sensor, and its reference is noisy or known now and then: no lag, no delay and no play.

use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::finding::Finding;
use identification::identify::{Options, identify};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const RUNS: usize = 4;
const ROWS: usize = 2400;
const STEP: f64 = 0.05;
const NOISE: f64 = 0.02;

/// A sensor with noise that forgets within `memory` (s), and a reference in one of so many rows with a third of that noise.
fn sensor(memory: f64, every: usize, seed: u64) -> Dataset {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
    let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
    let keep = if memory > 0.0 { f64::exp(-STEP / memory) } else { 0.0 };
    let mut columns: [Vec<f64>; 3] = Default::default();
    for run in 0..RUNS {
        let mut noise = draw();
        for row in 0..ROWS {
            let at = row as f64 * STEP;
            noise = keep * noise + (1.0 - keep * keep).sqrt() * draw();
            let beat = 0.6 + 0.1 * run as f64;
            let truth = 1.0 + 0.5 * (beat * at).sin() + 0.3 * (2.3 * beat * at + 1.0).sin();
            let seen = truth + NOISE / 3.0 * draw();
            let seen = if row.is_multiple_of(every) { seen } else { f64::NAN };
            let values = [at, truth + NOISE * noise, seen];
            columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        }
    }
    let named = [
        ("time", Role::Time, Unit::Second),
        ("gauge", Role::Measured, Unit::Volt),
        ("truth", Role::Reference, Unit::Volt),
    ];
    let columns = named.into_iter().zip(columns);
    let columns = columns.map(|((name, role, unit), v)| Column::new(name, role, unit, v)).collect();
    Dataset::new("gauge", Kind::Sensor, columns, (0..RUNS * ROWS).map(|row| row / ROWS).collect())
}

fn found(dataset: &Dataset) -> Finding {
    identify(dataset, None, &Options::default(), &mut |_, _| ()).unwrap().finding
}

/// The course between references held the noise of the very readings that have one: a delay explained a part of it.
#[test]
fn the_noise_of_readings_between_sparse_references_is_no_delay() {
    for seed in 1..5 {
        let finding = found(&sensor(0.0, 20, seed));
        assert_eq!(finding.effects, [], "{seed}");
    }
}

/// The noise of the sensor hid that of its reference, which a lag and an opposite delay then evened out. Its ends, known from one
/// side, were outliers.
#[test]
fn the_noise_of_a_reference_beside_slow_noise_of_the_sensor_is_no_lag() {
    for (every, seed) in [(1, 1), (1, 2), (2, 3), (2, 4)] {
        let finding = found(&sensor(0.7, every, seed));
        let causes = finding.effects.iter().filter(|effect| effect.term != "noise");
        assert_eq!(causes.count(), 0, "{every} {seed}: {:?}", finding.effects);
        assert_eq!(finding.set_aside, [], "{every} {seed}");
    }
}

/// A gyro in slow motion whose rate is measured five times a second, with noise of half the motion.
fn slow_gyro(seed: u64) -> Dataset {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
    let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
    let mut columns: [Vec<f64>; 3] = Default::default();
    for run in 0..RUNS {
        for row in 0..ROWS {
            let at = 0.01 * row as f64 + 40.0 * run as f64;
            let rate: f64 = [1.3, 3.0, 5.2, 8.2].iter().map(|beat| (beat * at).sin()).sum();
            let seen = if row.is_multiple_of(20) { rate + 0.5 * draw() } else { f64::NAN };
            let values = [at, 1.006 * rate + 0.5 + 0.3 * draw(), seen];
            columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        }
    }
    let named = [
        ("time", Role::Time, Unit::Second),
        ("gyro", Role::GyroRate, Unit::DegreePerSecond),
        ("table", Role::ReferenceRate, Unit::DegreePerSecond),
    ];
    let columns = named.into_iter().zip(columns);
    let columns = columns.map(|((name, role, unit), v)| Column::new(name, role, unit, v)).collect();
    Dataset::new("slow", Kind::Series, columns, (0..RUNS * ROWS).map(|row| row / ROWS).collect())
}

/// The noise of each reference was in the rate that the readings are compared with: a scale of -1 and four waves explained it.
#[test]
fn the_noise_of_sparse_rates_is_no_scale_error() {
    for seed in 1..4 {
        let finding = found(&slow_gyro(seed));
        assert_eq!(finding.effects, [], "{seed}");
        let scale = finding.base.iter().find(|one| one.name == "scale_factor").unwrap();
        let error = scale.standard_error.unwrap();
        assert!((scale.value - 0.006).abs() < 4.0 * error && error < 0.03, "{seed}: {scale:?}");
    }
}

/// Found by a fuzzer: the only reference stood in the last rows of a record.
#[test]
fn one_reference_at_the_end_of_a_record_is_judged() {
    const ROWS: usize = 60;
    let time: Vec<f64> = (0..ROWS).map(|row| 0.01 * row as f64).collect();
    let reads: Vec<f64> = time.iter().map(|at| (3.0 * at).sin()).collect();
    let truth = (0..ROWS).map(|row| if row + 2 == ROWS { 0.5 } else { f64::NAN }).collect();
    let data = Dataset::new(
        "end",
        Kind::Series,
        vec![
            Column::new("time", Role::Time, Unit::Second, time),
            Column::new("gyro", Role::GyroRate, Unit::DegreePerSecond, reads),
            Column::new("reference", Role::ReferenceRate, Unit::DegreePerSecond, truth),
        ],
        vec![0; ROWS],
    );
    if let Ok(finding) = identify(&data, None, &Options::default(), &mut |_, _| ()) {
        assert!(finding.finding.effects.is_empty(), "{:?}", finding.finding);
    }
}

/// Readings that fall as the reference rises follow it as well beside a scale of their own: evening the reference out is what
/// lowers the error, and not the sign.
#[test]
fn what_evening_a_reference_out_gains_is_no_gain_of_a_sign() {
    let mut reversed = sensor(0.0, 1, 1);
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(7);
    for column in &mut reversed.columns {
        let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
        match column.role {
            Role::Measured => column.values.iter_mut().for_each(|value| *value = -*value),
            Role::Reference => column.values.iter_mut().for_each(|value| *value += 0.1 * draw()),
            _ => {}
        }
    }
    let finding = found(&reversed);
    assert_eq!(finding.effects[0].name, "reversed_sign", "{:?}", finding.effects);
    assert!(finding.notices.iter().any(|one| one.contains("evened out")), "{:?}", finding.notices);
    let error = |at: usize| finding.path[at].held_out["gauge"].value;
    assert!((error(0) / error(1) - 1.0).abs() < 0.1, "{} {}", error(0), error(1));
}
