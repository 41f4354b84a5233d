//! What is found of a sensor does not depend on the unit that its readings are in.

use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::identify::{Options, identify};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const RUNS: usize = 5;
const ROWS: usize = 400;

type Cause = fn(&[f64], usize, f64) -> f64;

/// The name of what is found of readings in a unit of this `size`, and the held-out errors in the first unit.
fn found(cause: Cause, size: f64) -> (Vec<String>, [f64; 2]) {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(11);
    let (mut time, mut reads, mut truth, mut run_of_row) = (vec![], vec![], vec![], vec![]);
    for run in 0..RUNS {
        let begin = 1000.0 * run as f64;
        let at = |row: usize| begin + row as f64;
        let course = |t: f64| 6.0 + 3.0 * (t / 23.0).sin() + 2.0 * (t / 61.0).cos();
        let course: Vec<f64> = (0..ROWS).map(|row| course(at(row))).collect();
        for row in 0..ROWS {
            let noise: f64 = StandardNormal.sample(&mut random);
            time.push(at(row));
            reads.push(size * (cause(&course, row, at(row)) + 0.05 * noise));
            truth.push(course[row]);
            run_of_row.push(run);
        }
    }
    let columns = vec![
        Column::new("time", Role::Time, Unit::Second, time),
        Column::new("reads", Role::Measured, Unit::One, reads),
        Column::new("truth", Role::Reference, Unit::One, truth),
    ];
    let dataset = Dataset::new("any unit", Kind::Sensor, columns, run_of_row);
    let finding = identify(&dataset, None, &Options::default(), &mut |_, _| ()).unwrap().finding;
    let names = finding.effects.iter().map(|effect| effect.name.clone()).collect();
    let held_out = &finding.held_out;
    (names, [held_out.before, held_out.after].map(|error| error / size.abs()))
}

/// The limits of a scale were those of readings in the unit of the reference, so nothing was found in others.
#[test]
fn readings_in_another_unit_have_the_same_causes() {
    let warms: Cause = |course, row, t| course[row] * (1.0 + 0.3 * (-t / 900.0).exp());
    let late: Cause = |course, row, _| course[row.saturating_sub(2)];
    for (cause, name) in [(warms, "scale_warm_up"), (late, "delay")] {
        let (names, errors) = found(cause, 1.0);
        assert_eq!(names, [name]);
        for size in [300.0, 0.013, -40.0] {
            let (others, its) = found(cause, size);
            assert_eq!(others, names, "{size}");
            for (error, its) in errors.iter().zip(its) {
                assert!((its / error - 1.0).abs() < 1e-2, "{size}: {its} for {error}");
            }
        }
    }
}
