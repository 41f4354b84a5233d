//! Recordings that begin in the middle of a transient: the sensor follows what was before them.

use crate::intervals::{SETS, assert_held, noise, parameter};
use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::finding::Finding;
use identification::identify::{Options, identify};

/// Four recordings at 10 Hz.
const RUNS: usize = 4;
const ROWS: usize = 600;

/// What goes on before, in and after a recording: levels that hold for 15 s and are left within a second.
fn level(at: f64) -> f64 {
    let of = |step: f64| 6.0 * (4.1 * step).sin() + 3.0 * (1.7 * step).cos();
    let (step, since) = ((at / 15.0).floor(), at.rem_euclid(15.0).min(1.0));
    of(step) + (of(step + 1.0) - of(step)) * since * since * (3.0 - 2.0 * since)
}

/// `level` through a lag from long before each recording, which begins `into` s after a step. `reads` has what comes out of it.
fn recorded((constant, into): (f64, f64), mut reads: impl FnMut(f64) -> f64) -> Finding {
    const FINE: f64 = 0.01;
    let (mut times, mut levels, mut readings) = (vec![], vec![], vec![]);
    for run in 0..RUNS {
        let begins = 450.0 * run as f64 + into;
        let mut lagged = level(begins - 150.0);
        for step in -15_000..10 * ROWS as i64 {
            let at = begins + FINE * step as f64;
            lagged += (level(at - FINE / 2.0) - lagged) * (1.0 - (-FINE / constant).exp());
            if step >= 0 && step % 10 == 0 {
                times.push(at);
                levels.push(level(at));
                readings.push(reads(lagged));
            }
        }
    }
    let columns = vec![
        Column::new("time", Role::Time, Unit::Second, times),
        Column::new("reading", Role::Measured, Unit::Volt, readings),
        Column::new("truth", Role::Reference, Unit::Volt, levels),
    ];
    let run = (0..RUNS * ROWS).map(|row| row / ROWS).collect();
    let dataset = Dataset::new("steps", Kind::Sensor, columns, run);
    identify(&dataset, None, &Options::default(), &mut |_, _| ()).unwrap().finding
}

/// A slow sensor, whose time constant is another in each set.
fn slow(seed: u64, into: f64) -> (f64, Finding) {
    let (constant, mut draw) = (1.5 + 0.15 * seed as f64, noise(300 + seed));
    let finding = recorded((constant, into), |late| late + 0.2 + 0.1 * draw());
    let first = finding.effects.first().map(|effect| effect.name.as_str());
    assert_eq!(first, Some("bandwidth"), "{seed} {into}");
    (constant, finding)
}

/// In equilibrium at the first row, the model made up for the state that it did not know by its time constant, or the errors there
/// hid the lag: they were a random walk.
#[test]
fn the_time_constant_of_a_slow_sensor_holds_where_a_recording_begins_in_a_transient() {
    let findings: Vec<(f64, Finding)> = (0..SETS).map(|seed| slow(seed, 2.0)).collect();
    let all: Vec<_> = findings
        .iter()
        .map(|(constant, one)| (*constant, parameter(one, "bandwidth", "time_constant")))
        .collect();
    assert_held(&all, 0.008);
}
