//! The number of causes is limited over all axes together, and the least useful is left out.

use identification::dataset::{Axis, Column, Dataset, Kind, Role, Unit};
use identification::finding::Finding;
use identification::identify::{Options, identify};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const ROWS: usize = 600;
/// Noise of a reading, deg/s.
const NOISE: f64 = 1e-3;

/// Two axes at rest: a load adds to the bias of x as much as the noise, and to that of y three times as much.
fn found(options: &Options) -> Finding {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(3);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let load: Vec<f64> = (0..ROWS).map(|_| normal()).collect();
    let mut columns = vec![Column::new(
        "time",
        Role::Time,
        Unit::Second,
        (0..ROWS).map(|row| 10.0 * row as f64).collect(),
    )];
    for (axis, name, slope) in [(Axis::X, "gyro_x", 1.0), (Axis::Y, "gyro_y", 3.0)] {
        let gyro = load.iter().map(|load| 0.02 + NOISE * (slope * load + normal())).collect();
        let mut gyro = Column::new(name, Role::GyroRate, Unit::DegreePerSecond, gyro);
        gyro.axis = Some(axis);
        columns.push(gyro);
    }
    let rest = vec![0.0; ROWS];
    columns.push(Column::new("reference", Role::ReferenceRate, Unit::DegreePerSecond, rest));
    columns.push(Column::new("load", Role::Auxiliary, Unit::Ampere, load));
    let runs = (0..ROWS).map(|row| row / 100).collect();
    let dataset = Dataset::new("bench", Kind::Series, columns, runs);
    identify(&dataset, None, options, &mut |_, _| {}).unwrap().finding
}

fn axes(finding: &Finding) -> Vec<Option<Axis>> {
    finding.effects.iter().map(|effect| effect.axis).collect()
}

#[test]
fn the_limit_holds_for_all_axes_together() {
    let usual = Options::default();
    assert!(usual.max_effects <= 6, "more causes than an engineer signs");
    assert_eq!(axes(&found(&usual)), [Some(Axis::Y), Some(Axis::X)]);
    assert_eq!(axes(&found(&Options { max_effects: 1, ..usual })), [Some(Axis::Y)]);
}
