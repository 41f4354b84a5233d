//! An effect that is certain in the whole of the data and predicts no held-out run is not added, and not hidden either.

use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::finding::{Finding, Verdict};
use identification::identify::{Options, identify};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const RUNS: usize = 9;
const ROWS: usize = 80;
/// Noise of a reading, deg/s.
const NOISE: f64 = 1e-3;

/// A gyro at rest with a load that changes from reading to reading, and a bias of `slope` (of a run) times the load.
fn found(slope: impl Fn(usize) -> f64) -> Finding {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(5);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let load: Vec<f64> = (0..RUNS * ROWS).map(|_| normal()).collect();
    let gyro = load
        .iter()
        .enumerate()
        .map(|(row, load)| 0.02 + NOISE * (slope(row / ROWS) * load + normal()))
        .collect();
    let rate = |name: &str, role, values| Column::new(name, role, Unit::DegreePerSecond, values);
    let rows = 0..RUNS * ROWS;
    let columns = vec![
        Column::new("time", Role::Time, Unit::Second, rows.map(|row| 10.0 * row as f64).collect()),
        rate("reference", Role::ReferenceRate, vec![0.0; RUNS * ROWS]),
        rate("gyro", Role::GyroRate, gyro),
        Column::new("load", Role::Auxiliary, Unit::Ampere, load),
    ];
    let runs = (0..RUNS * ROWS).map(|row| row / ROWS).collect();
    let dataset = Dataset::new("bench", Kind::Series, columns, runs);
    identify(&dataset, None, &Options::default(), &mut |_, _| {}).unwrap().finding
}

#[test]
fn what_comes_and_goes_between_runs_is_left() {
    let finding = found(|run| if run % 2 == 0 { 0.8 } else { -0.24 });
    assert!(finding.effects.is_empty(), "{:?}", finding.effects);
    assert_eq!(finding.verdict, Verdict::StructureLeft);
    assert!(finding.left.iter().any(|left| left.drivers == ["load"]), "{:?}", finding.left);
}

#[test]
fn what_is_in_every_run_is_added() {
    let finding = found(|_| 0.4);
    let drivers: Vec<&[String]> = finding.effects.iter().map(|one| &*one.drivers).collect();
    assert_eq!(drivers, [["load"]]);
    assert_eq!((finding.verdict, finding.left.len()), (Verdict::Explained, 0));
}
