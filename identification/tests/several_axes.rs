//! A sensor with three axes against a reference with three: each is identified, and leakage from one to another has a name.

use crate::set_right::{effect, found};
use identification::dataset::{Axis, Column, Dataset, Kind, Role, Unit};
use identification::identify::predict;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const RUNS: usize = 6;
const ROWS: usize = 600;

/// An accelerometer that is shaken about three axes; `reads` says what it makes of that.
fn accelerometer(reads: impl Fn([f64; 3]) -> [f64; 3]) -> Dataset {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(4);
    let mut columns: Vec<Column> = vec![Column::new("t", Role::Time, Unit::Second, Vec::new())];
    for (role, name) in [(Role::Measured, "a"), (Role::Reference, "r")] {
        for (axis, letter) in [(Axis::X, "x"), (Axis::Y, "y"), (Axis::Z, "z")] {
            let unit = Unit::MetrePerSecondSquared;
            let column = Column::new(&format!("{name}{letter}"), role, unit, Vec::new());
            columns.push(Column { axis: Some(axis), ..column });
        }
    }
    for run in 0..RUNS {
        for row in 0..ROWS {
            let t = row as f64 * 0.02;
            let wave = |axis: f64| {
                let phase = run as f64 * (1.3 + axis);
                4.0 * ((1.1 + 0.37 * axis) * t + phase).sin() + 2.0 * ((2.9 - 0.4 * axis) * t).cos()
            };
            let truth = [wave(0.0), wave(1.0), wave(2.0)];
            let read = reads(truth).map(|value| {
                let noise: f64 = StandardNormal.sample(&mut random);
                value + 0.02 * noise
            });
            let values = std::iter::once(t).chain(read).chain(truth);
            columns.iter_mut().zip(values).for_each(|(column, value)| column.values.push(value));
        }
    }
    let run_of_row = (0..RUNS * ROWS).map(|row| row / ROWS).collect();
    Dataset::new("shaken", Kind::Sensor, columns, run_of_row)
}

/// The first axis alone took part, and its reference was evened out to fit the readings of the others.
#[test]
fn what_leaks_from_another_axis_is_told_and_taken_off() {
    let dataset = accelerometer(|[x, y, z]| [x + 0.01 * y, y, 1.004 * z]);
    let identified = found(&dataset);
    let finding = &identified.finding;
    let told = effect(finding, "misaligned_axis");
    assert_eq!((told.axis, &*told.drivers), (Some(Axis::X), &["ry".to_owned()][..]));
    assert!((told.parameters[0].value - 0.01).abs() < 0.001, "{told:?}");
    assert_eq!(finding.effects.len(), 1, "{:?}", finding.effects);
    assert_eq!(finding.held_out_also.len(), 2);
    let after = predict(&dataset, &identified.model).unwrap().rmse.after;
    assert!(after < 0.022, "{after}");
    let all: Vec<_> = finding.compensations().collect();
    let x = all.iter().find(|one| one.of == "ax").expect("a compensation of x");
    assert!(x.held_out.after < 0.022 && x.held_out.before > 0.03, "{:?}", x.held_out);
    // Firmware reads the other axis, and not its truth.
    assert!(x.inputs.iter().any(|input| input.of == "ay"), "{:?}", x.inputs);
    assert!(all.iter().any(|one| one.of == "az"), "the scale of z");
}

#[test]
fn axes_that_are_named_unlike_are_told() {
    let finding = found(&accelerometer(|[x, y, z]| [x, z, y])).finding;
    let names: Vec<&str> = finding.effects.iter().map(|effect| &*effect.name).collect();
    assert_eq!(names, ["wrong_axis"; 2]);
    assert!(finding.held_out.after < 0.022, "{:?}", finding.held_out);
}
