//! A reference that stands still beside readings that move, and the reverse: no cause, but fields that do not belong together.

use crate::recorded::recorded;
use crate::set_right::{found, robot, shaken};
use identification::dataset::{Column, Dataset, Role, Unit};
use identification::finding::Verdict;
use identification::identify::{Options, identify};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

fn noise(count: usize, sigma: f64) -> Vec<f64> {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(8);
    let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
    (0..count).map(|_| sigma * draw()).collect()
}

/// Gives `name` these values.
fn put(dataset: &mut Dataset, name: &str, values: Vec<f64>) {
    dataset.columns.iter_mut().find(|column| column.name == name).unwrap().values = values;
}

fn refused(dataset: &Dataset) -> String {
    identify(dataset, None, &Options::default(), &mut |_, _| ()).unwrap_err().to_string()
}

/// A table in steps of 10 deg/s that hold for a minute each.
fn table() -> Dataset {
    let recorded = recorded(2, 1800, 1.0);
    recorded.series(&recorded.white(1).iter().map(|white| 0.1 * white).collect::<Vec<f64>>())
}

#[test]
fn a_rate_that_stands_beside_a_gyro_that_turns_is_told() {
    let stands = "the reference `reference_rate` does not move while `gyro` turns by 60.";
    for (level, sigma) in [(0.0, 0.0), (5.0, 0.0), (0.0, 0.05)] {
        let mut still = table();
        let values = noise(still.rows(), sigma).iter().map(|noise| level + noise).collect();
        put(&mut still, "reference_rate", values);
        assert!(refused(&still).starts_with(stands), "{}", refused(&still));
    }
    let mut still = table();
    let rows = still.rows();
    put(&mut still, "gyro", noise(rows, 0.1));
    let told = refused(&still);
    assert!(told.starts_with("`gyro` does not move while its reference `reference_rate` moves by"));
}

#[test]
fn a_heading_that_stands_beside_a_gyro_that_turns_is_told() {
    let mut still = table();
    still.columns.retain(|column| !["reference_rate", "heading"].contains(&column.name.as_str()));
    let rows = still.rows();
    let every_ten = |of: &dyn Fn(usize) -> f64| -> Vec<f64> {
        (0..rows).map(|row| if row % 10 == 0 { of(row) } else { f64::NAN }).collect()
    };
    let heading = every_ten(&|_| 30.0);
    still.columns.push(Column::new("north", Role::ReferenceHeading, Unit::Degree, heading));
    assert!(refused(&still).starts_with("the reference `north` does not move while `gyro` turns"));
}

#[test]
fn of_several_axes_the_one_whose_reference_stands_is_left_out() {
    let mut one = shaken(0.0, |rates| rates);
    let rows = one.rows();
    put(&mut one, "rz", vec![0.0; rows]);
    let finding = found(&one).finding;
    assert_eq!((finding.verdict, finding.held_out_also.len()), (Verdict::NothingMissing, 1));
    let told = |notice: &String| {
        notice.starts_with("the reference `rz` does not move while `gz` turns by")
            && notice.ends_with(": it is left out")
    };
    assert!(finding.notices.iter().any(told), "{:?}", finding.notices);
}

#[test]
fn poses_that_stand_while_the_wheels_drive_are_told_and_the_reverse() {
    let mut still = robot(0.0, 0.0);
    for column in still.columns.iter_mut().filter(|column| column.role.is_reference()) {
        let count = column.values.len();
        column.values = noise(count, 0.002);
    }
    let told = refused(&still);
    assert!(told.starts_with("the reference of the path does not move while the wheels drive"));
    let mut still = robot(0.0, 0.0);
    for name in ["left", "right"] {
        let rows = still.rows();
        put(&mut still, name, noise(rows, 1e-5));
    }
    let told = refused(&still);
    assert!(told.starts_with("the wheels stand still while the reference of the path moves by"));
}

/// A gauge at 2 Hz for half an hour, and what else was recorded.
fn gauge(unit: Unit, reads: &dyn Fn(f64) -> f64, truth: f64, beside: Vec<Column>) -> Dataset {
    let rows = 3600;
    let times: Vec<f64> = (0..rows).map(|row| f64::from(row) * 0.5).collect();
    let readings = times.iter().zip(noise(times.len(), 0.02)).map(|(t, noise)| reads(*t) + noise);
    let mut columns = vec![
        Column::new("gauge", Role::Measured, unit, readings.collect()),
        Column::new("truth", Role::Reference, unit, vec![truth; times.len()]),
        Column::new("time", Role::Time, Unit::Second, times),
    ];
    columns.extend(beside);
    let run = (0..3600).map(|row| row / 900).collect();
    Dataset::new("gauge", identification::dataset::Kind::Sensor, columns, run)
}

/// A reference that was never connected: waves of what is measured, or its levels.
#[test]
fn a_reference_that_stands_beside_any_sensor_that_moves_is_told() {
    let wave = |t: f64| 3.0 + 2.0 * (t / 11.0).sin() + (t / 4.7).cos();
    let levels = |t: f64| 3.0 + 2.0 * (7.3 * (t / 30.0).floor()).sin();
    let supply = || {
        let values = noise(3600, 0.01).iter().map(|noise| 12.0 + noise).collect();
        vec![Column::new("supply", Role::Auxiliary, Unit::Volt, values)]
    };
    let told = "the reference `truth` does not move while `gauge` moves by ";
    let advice = "give the column that measures what `gauge` does as its reference";
    for truth in [0.0, 1e-4, 3.0] {
        for reads in [&wave as &dyn Fn(f64) -> f64, &levels] {
            for beside in [vec![], supply()] {
                let said = refused(&gauge(Unit::Volt, reads, truth, beside));
                assert!(said.contains(told) && said.contains(advice), "{truth}: {said}");
            }
        }
    }
    // An angle has no zero of its own: 20 deg to each side.
    let said = refused(&gauge(Unit::Radian, &|t| 0.15 * (wave(t) - 3.0), 1.2, vec![]));
    assert!(said.contains(told), "{said}");
}

/// Beside a constant reference, at zero or not, a sensor at rest shows what moves it, and its slow noise.
#[test]
fn a_sensor_at_rest_is_no_sensor_that_moves() {
    let heat = |t: f64| 25.0 + 5.0 * (t / 30.0).sin();
    let times = || (0..3600).map(|row| f64::from(row) * 0.5);
    for (role, unit) in [(Role::Temperature, Unit::Celsius), (Role::Auxiliary, Unit::Volt)] {
        for truth in [0.0, 3.0] {
            let cause = vec![Column::new("cause", role, unit, times().map(heat).collect())];
            let reads = |t: f64| truth + 0.4 * (heat(t) - 25.0);
            let finding = found(&gauge(Unit::Volt, &reads, truth, cause)).finding;
            assert!(finding.effects[0].drivers[0].contains("cause"), "{:?}", finding.effects);
        }
    }
    for truth in [0.0, 1e-4, 3.0] {
        let mut slow = gauge(Unit::Volt, &|_| truth, truth, vec![]);
        let mut level = 0.0;
        for (value, step) in slow.columns[0].values.iter_mut().zip(noise(3600, 0.2)) {
            level = 0.98 * level + step;
            *value += level;
        }
        let identified = identify(&slow, None, &Options::default(), &mut |_, _| ());
        assert!(identified.is_ok(), "{truth}: {:?}", identified.err());
    }
}

/// 10 deg/s over 10 K, there and back nine times: more than most gyros turn by.
#[test]
fn a_bias_that_swings_with_the_temperature_is_no_motion() {
    let mut recorded = recorded(1, 3600, 1.0);
    for (row, value) in recorded.temperature.iter_mut().enumerate() {
        *value = 25.0 + 5.0 * (row as f64 / 60.0).sin();
    }
    recorded.rate.fill(0.0);
    let white = recorded.white(4);
    let bias = |row: usize| recorded.temperature[row] - 25.0 + 0.1 * white[row];
    let finding = found(&recorded.series(&(0..3600).map(bias).collect::<Vec<f64>>())).finding;
    assert_eq!(finding.effects.len(), 1, "{:?}", finding.effects);
    assert_eq!(finding.effects[0].name, "bias_over_temperature");
}

/// A run of which a single reading has a reference tells nothing, and would count as much as a whole one.
#[test]
fn a_run_with_one_reading_left_is_left_out_by_name() {
    let rows = 603;
    let run: Vec<usize> = (0..rows).map(|row| row / 100).collect();
    let truth: Vec<f64> = (0..rows).map(|row| 5.0 * (row as f64 / 7.0).sin()).collect();
    let mut reading: Vec<f64> =
        truth.iter().zip(noise(rows, 0.05)).map(|(truth, noise)| truth + 0.2 + noise).collect();
    let read = |reading: &[f64]| {
        let columns = vec![
            Column::new("time", Role::Time, Unit::Second, (0..rows).map(|t| t as f64).collect()),
            Column::new("w", Role::GyroRate, Unit::DegreePerSecond, reading.to_vec()),
            Column::new("truth", Role::ReferenceRate, Unit::DegreePerSecond, truth.clone()),
        ];
        let dataset =
            Dataset::new("runs", identification::dataset::Kind::Series, columns, run.clone());
        identify(&dataset, None, &Options::default(), &mut |_, _| ()).unwrap()
    };
    let says = |notices: &[String]| notices.iter().any(|one| one.contains("left out of `w`"));
    assert!(!says(&read(&reading).finding.notices));
    // Two of the three rows of the last run are lost.
    reading[601..].fill(f64::NAN);
    let identified = read(&reading);
    let notices = &identified.finding.notices;
    let expected = "run 6 is left out of `w`: one reading with a reference is left of it";
    assert!(notices.iter().any(|one| one == expected), "{notices:?}");
    assert_eq!(identified.diagnostics.blocks[0].time.len(), 600);
}
