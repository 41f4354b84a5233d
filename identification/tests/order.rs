//! The cause that matters first.

use identification::dataset::{Axis, Column, Dataset, Kind, Role, Unit};
use identification::identify::{Options, identify};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// Of two axes, one is read ten times as often. Its error is more certain, and that of the other one is larger.
#[test]
fn effects_stand_in_the_order_of_what_they_do_on_held_out_runs() {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(41);
    let rows = 4000;
    let rate = |row: usize, phase: f64| 20.0 * (row as f64 / 31.0 + phase).sin();
    let warm = |row: usize| 20.0 + 8.0 * (row as f64 / 170.0).sin();
    let time = (0..rows).map(|row| row as f64).collect();
    let mut columns = vec![
        Column::new("time", Role::Time, Unit::Second, time),
        Column::new("warmth", Role::Temperature, Unit::Celsius, (0..rows).map(warm).collect()),
    ];
    for (axis, every, slope) in [(Axis::Y, 10, 0.06), (Axis::Z, 1, 0.02)] {
        let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
        let read = |row: usize| {
            let value = rate(row, every as f64) + slope * (warm(row) - 20.0) + 0.1 * draw();
            if row.is_multiple_of(every) { value } else { f64::NAN }
        };
        let readings: Vec<f64> = (0..rows).map(read).collect();
        let truth = (0..rows).map(|row| rate(row, every as f64)).collect();
        for (name, role, values) in
            [("gyro", Role::GyroRate, readings), ("rate", Role::ReferenceRate, truth)]
        {
            let column =
                Column::new(&format!("{name} {axis:?}"), role, Unit::DegreePerSecond, values);
            columns.push(Column { axis: Some(axis), ..column });
        }
    }
    let run = (0..rows).map(|row| row * 5 / rows).collect();
    let dataset = Dataset::new("order", Kind::Series, columns, run);
    let finding = identify(&dataset, None, &Options::default(), &mut |_, _| ()).unwrap().finding;
    let axes: Vec<_> = finding.effects.iter().map(|effect| effect.axis).collect();
    assert_eq!(axes, [Some(Axis::Y), Some(Axis::Z)], "{:?}", finding.effects);
}
