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

/// A gyro at rest whose temperature moves from long before each recording on, and a bias of 0.01 deg/s/K over what comes of it.
fn warmed(seed: u64, mut seen: impl FnMut(f64) -> f64) -> Finding {
    let mut draw = noise(seed);
    let (mut times, mut levels, mut readings) = (vec![], vec![], vec![]);
    for run in 0..RUNS {
        let phases = [draw(), draw(), draw()];
        let level = |row: i64| {
            let of = |(wave, phase): (usize, &f64)| {
                let turns = (0.5 + 0.45 * wave as f64 + 0.05 * run as f64) * row as f64;
                4.0 * (turns / 100.0 + 3.0 * phase).sin()
            };
            30.0 + phases.iter().enumerate().map(of).sum::<f64>()
        };
        for row in -2000..1000 {
            let bias = 0.01 * seen(level(row));
            if row >= 0 {
                times.push((3000 * run as i64 + row) as f64);
                levels.push(level(row) + 0.005 * draw());
                readings.push(0.1 + bias + 0.01 * draw());
            }
        }
    }
    let rows = times.len();
    let columns = vec![
        Column::new("time", Role::Time, Unit::Second, times),
        Column::new("gyro", Role::GyroRate, Unit::DegreePerSecond, readings),
        Column::new("table", Role::ReferenceRate, Unit::DegreePerSecond, vec![0.0; rows]),
        Column::new("temperature", Role::Temperature, Unit::Celsius, levels),
    ];
    let run = (0..rows).map(|row| row * RUNS / rows).collect();
    let dataset = Dataset::new("warmed", Kind::Series, columns, run);
    identify(&dataset, None, &Options::default(), &mut |_, _| ()).unwrap().finding
}

/// Asserts that most of what is found is that effect and nothing else, and that its slope is right.
fn assert_alone(name: &str, found: impl Fn(u64) -> Finding) {
    let findings: Vec<Finding> = (0..6).map(found).collect();
    let names = |one: &Finding| one.effects.iter().map(|it| it.name.clone()).collect::<Vec<_>>();
    let all: Vec<Vec<String>> = findings.iter().map(names).collect();
    assert!(all.iter().filter(|names| *names == &[name]).count() >= 5, "{all:?}");
    for one in &findings {
        let slope = parameter(one, name, "slope");
        let error = slope.standard_error.unwrap();
        assert!((slope.value - 0.01).abs() < 3.0 * error, "{slope:?}");
    }
}

/// What was left of the state at the beginning of each recording was a random walk, and the slope a seventh too small.
#[test]
fn a_lag_of_a_temperature_that_moves_when_a_recording_begins_is_all_there_is() {
    assert_alone("bias_temperature_lag", |seed| {
        let mut late = 30.0;
        warmed(seed, move |level| {
            late += (level - late) * (1.0 - (-1.0_f64 / 50.0).exp());
            late
        })
    });
}

#[test]
fn a_hysteresis_that_is_not_in_its_middle_when_a_recording_begins_is_all_there_is() {
    assert_alone("thermal_hysteresis", |seed| {
        let mut at = 30.0_f64;
        warmed(seed, move |level| {
            at = at.clamp(level - 3.0, level + 3.0);
            at
        })
    });
}
