//! Rows that are wrong by themselves take no part and are told; an error that goes with an input stays an error.

use super::set_right::robot;
use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::finding::{Finding, Verdict};
use identification::identify::{Options, identify, predict};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

const ROWS: usize = 3000;
const NOISE: f64 = 0.02;

fn found(dataset: &Dataset) -> Finding {
    identify(dataset, None, &Options::default(), &mut |_, _| ()).unwrap().finding
}

/// A pressure and a sensor of it, whose reading changes by `drift` (of its noise) over 10 K.
fn gauge(drift: f64, seed: u64) -> Dataset {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
    let mut columns: [Vec<f64>; 4] = Default::default();
    for row in 0..ROWS {
        let at = row as f64;
        let truth = 5.0 + 2.0 * (at / 29.0).sin() + (at / 173.0).cos();
        let temperature = 25.0 + 10.0 * (at / 260.0).sin();
        let drawn: f64 = StandardNormal.sample(&mut random);
        let reads = 1.01 * truth + 0.1 + NOISE * (drawn + drift * (temperature - 25.0) / 10.0);
        let values = [at, reads, truth, temperature];
        columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
    }
    let named = [
        ("time", Role::Time, Unit::Second),
        ("gauge", Role::Measured, Unit::Volt),
        ("truth", Role::Reference, Unit::Volt),
        ("room", Role::Temperature, Unit::Celsius),
    ];
    let columns = named.into_iter().zip(columns);
    let columns = columns.map(|((name, role, unit), v)| Column::new(name, role, unit, v)).collect();
    Dataset::new("gauge", Kind::Sensor, columns, (0..ROWS).map(|row| row / 500).collect())
}

fn values<'a>(dataset: &'a mut Dataset, name: &str) -> &'a mut Vec<f64> {
    &mut dataset.columns.iter_mut().find(|column| column.name == name).unwrap().values
}

/// Rows that a careless logger spoils, one in a hundred: spikes, zeros, values of other rows, wrong references.
fn spoil(dataset: &mut Dataset, seed: u64) -> usize {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
    let mut count = 0;
    for row in 20..ROWS - 20 {
        if !random.random_bool(0.01) {
            continue;
        }
        count += 1;
        let other = random.random_range(0..ROWS);
        match count % 4 {
            0 => values(dataset, "gauge")[row] += random.random_range(0.5..200.0),
            1 => values(dataset, "gauge")[row] = 0.0,
            2 => values(dataset, "gauge")[row] = 9.0 + 1e-4 * other as f64,
            _ => values(dataset, "truth")[row] -= random.random_range(0.5..4.0),
        }
    }
    count
}

#[test]
fn nothing_is_missing_beside_outliers_which_are_counted() {
    for seed in 1..5 {
        let mut dataset = gauge(0.0, seed);
        let count = spoil(&mut dataset, seed);
        let finding = found(&dataset);
        assert_eq!(finding.verdict, Verdict::NothingMissing, "{seed} {:?}", finding.left);
        let [aside] = finding.set_aside.as_slice() else { panic!("{:?}", finding.set_aside) };
        assert_eq!((aside.quantity.as_str(), aside.rows), ("gauge", count), "{seed}");
        assert!(finding.held_out.after < 1.05 * NOISE, "{:?}", finding.held_out);
        let said = finding.in_words().remove(0);
        assert!(said.starts_with(&format!("{count} of ")) && said.contains("outliers"), "{said}");
    }
}

#[test]
fn an_effect_beside_outliers_is_that_without_them() {
    let clean = found(&gauge(0.5, 6));
    let mut dataset = gauge(0.5, 6);
    spoil(&mut dataset, 6);
    let finding = found(&dataset);
    assert_eq!(finding.verdict, Verdict::Explained, "{:?}", finding.left);
    let of = |finding: &Finding| {
        let names: Vec<String> = finding.effects.iter().map(|one| one.name.clone()).collect();
        (names, finding.effects[0].parameters[0].value)
    };
    let ((names, slope), (clean_names, clean_slope)) = (of(&finding), of(&clean));
    assert_eq!(names, clean_names);
    assert!((slope / clean_slope - 1.0).abs() < 0.05, "{slope} {clean_slope}");
}

/// What a broken logger writes into one cell, in any field.
#[test]
fn one_cell_however_large_changes_nothing_and_is_told() {
    let clean = found(&gauge(0.5, 8));
    let slope = |finding: &Finding| finding.effects[0].parameters[0].value;
    for name in ["gauge", "truth", "room"] {
        for value in [1e9, 1e30, -1e300].into_iter().skip(usize::from(name == "room")) {
            let mut dataset = gauge(0.5, 8);
            values(&mut dataset, name)[1234] = value;
            let finding = found(&dataset);
            let [aside] = finding.set_aside.as_slice() else {
                panic!("{name} {value}: {:?}", finding.set_aside)
            };
            assert_eq!((aside.rows, aside.times.as_slice()), (1, &[1234.0][..]), "{name} {value}");
            assert_eq!(finding.verdict, clean.verdict, "{name} {value} {:?}", finding.left);
            assert_eq!(finding.effects.len(), clean.effects.len(), "{name} {value}");
            assert!((slope(&finding) / slope(&clean) - 1.0).abs() < 0.02, "{name} {value}");
            assert!(finding.in_words()[0].len() < 200, "{}", finding.in_words()[0]);
        }
    }
    let clean = found(&robot(0.0, 0.0));
    let mut dataset = robot(0.0, 0.0);
    values(&mut dataset, "left")[100] = 1e30;
    let finding = found(&dataset);
    assert_eq!(finding.set_aside.len(), 1, "{:?}", finding.set_aside);
    let ratio = finding.held_out.after / clean.held_out.after;
    assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
}

#[test]
fn a_prediction_leaves_out_the_same_rows_and_holds_nothing_but_figures() {
    let identified =
        identify(&gauge(0.5, 6), None, &Options::default(), &mut |_, _| ()).unwrap().model;
    let mut dataset = gauge(0.5, 9);
    let count = spoil(&mut dataset, 9);
    values(&mut dataset, "gauge")[7] = 1e300;
    let told = predict(&dataset, &identified).unwrap();
    assert!(told.rmse.after < 1.05 * NOISE, "{:?}", told.rmse);
    assert_eq!(told.set_aside.iter().map(|one| one.rows).sum::<usize>(), count + 1);
    assert_eq!(told.at.len(), told.residual.len());
    assert!(told.at.len() < ROWS && !told.at.contains(&7));
    assert!(told.predicted.iter().chain(&told.residual).all(|figure| figure.is_finite()));
    // Where the ends of runs are compared, no other row has a figure.
    let robot = robot(0.0, 0.0);
    let model = identify(&robot, None, &Options::default(), &mut |_, _| ()).unwrap().model;
    let ends = predict(&robot, &model).unwrap();
    assert_eq!((ends.quantity.as_str(), ends.predicted.len()), ("final_position", 0));
    assert_eq!((ends.at.len(), ends.residual.len()), (robot.run_labels.len(), ends.at.len()));
}

/// A gauge that sticks at its end for a few rows at a time: as rare and as large as outliers.
#[test]
fn a_rare_error_that_goes_with_an_input_is_no_outlier() {
    let mut dataset = gauge(0.0, 7);
    let truth = values(&mut dataset, "truth").clone();
    let mut rare = 0;
    for (reads, truth) in values(&mut dataset, "gauge").iter_mut().zip(truth) {
        if truth > 7.8 {
            *reads -= 0.6;
            rare += 1;
        }
    }
    assert!((10..ROWS / 20).contains(&rare), "{rare}");
    let finding = found(&dataset);
    assert_eq!(finding.set_aside, []);
    assert_ne!(finding.verdict, Verdict::NothingMissing);
}

#[test]
fn wrong_poses_and_wrong_counts_of_a_robot_take_no_part() {
    let of = |finding: &Finding| {
        let names: Vec<String> = finding.effects.iter().map(|one| one.name.clone()).collect();
        (names, finding.effects[0].parameters[0].value, finding.held_out.after)
    };
    let (clean_names, track, error) = of(&found(&robot(0.0, 0.0)));
    let wrong: [(&str, f64); 4] =
        [("x", 0.7), ("heading", 2.0), ("heading", std::f64::consts::PI), ("left", 0.4)];
    for (name, by) in wrong {
        let mut dataset = robot(0.0, 0.0);
        let rows = dataset.rows();
        let at: Vec<usize> =
            (37..rows).step_by(101).filter(|row| row % 300 > 6 && row % 300 < 294).collect();
        at.iter().for_each(|&row| values(&mut dataset, name)[row] += by);
        let finding = found(&dataset);
        let [aside] = finding.set_aside.as_slice() else {
            panic!("{name} {:?}", finding.set_aside)
        };
        assert!(aside.rows.abs_diff(at.len()) <= 1, "{name} {} {}", aside.rows, at.len());
        let (names, its_track, its_error) = of(&finding);
        assert_eq!(names, clean_names, "{name}");
        assert!((its_track - track).abs() < 0.002, "{name} {its_track} {track}");
        assert!(its_error < 2.0 * error, "{name} {its_error} {error}");
    }
}
