//! A memory that the noise model does not declare is structure; one that it declares is noise.

use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::finding::{Finding, Verdict};
use identification::identify::{Options, identify};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const RUNS: usize = 3;
const ROWS: usize = 600;
/// Noise of a reading, deg/s.
const NOISE: f64 = 0.01;
/// Slope over the supply, deg/s/V.
const SLOPE: f64 = 0.05;
/// Correlation time of the slow part, s.
const MEMORY_S: f64 = 15.0;

/// Recordings at rest under a changing supply. The slow part of the noise has that share of the white part.
fn at_rest(slope: f64, slow_part: f64) -> Dataset {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(11);
    let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
    let keep = (-1.0 / MEMORY_S).exp();
    let (mut time, mut gyro, mut supply) = (Vec::new(), Vec::new(), Vec::new());
    for run in 0..RUNS {
        let mut slow = draw();
        for row in 0..ROWS {
            slow = keep * slow + (1.0 - keep * keep).sqrt() * draw();
            let volt = (row as f64 / 40.0 + run as f64).sin();
            time.push(row as f64);
            supply.push(12.0 + volt);
            gyro.push(0.02 + slope * volt + NOISE * (draw() + slow_part * slow));
        }
    }
    Dataset::new(
        "bench",
        Kind::Series,
        vec![
            Column::new(
                "reference",
                Role::ReferenceRate,
                Unit::DegreePerSecond,
                vec![0.0; time.len()],
            ),
            Column::new("time", Role::Time, Unit::Second, time),
            Column::new("gyro", Role::GyroRate, Unit::DegreePerSecond, gyro),
            Column::new("supply", Role::Auxiliary, Unit::Volt, supply),
        ],
        (0..RUNS * ROWS).map(|row| row / ROWS).collect(),
    )
}

fn found(dataset: &Dataset, noise_from: Option<Dataset>) -> Finding {
    let options = Options { noise_from, ..Options::default() };
    identify(dataset, None, &options, &mut |_, _| {}).unwrap().finding
}

fn says(finding: &Finding, words: &str) -> bool {
    finding.notices.iter().any(|notice| notice.contains(words))
}

#[test]
fn a_memory_that_the_noise_model_declares_is_noise() {
    let finding = found(&at_rest(SLOPE, 0.7), None);
    assert_eq!(finding.verdict, Verdict::Explained, "{finding:#?}");
    assert!(says(&finding, "is white at the level of 1 %"), "{finding:#?}");
    assert!(finding.left.is_empty());
}

#[test]
fn a_memory_that_it_was_not_told_of_is_structure() {
    let finding = found(&at_rest(SLOPE, 0.7), Some(at_rest(0.0, 0.0)));
    assert_eq!(finding.effects[0].name, "supply_voltage", "{finding:#?}");
    assert!(finding.held_out.after < finding.held_out.before);
    assert_eq!(finding.verdict, Verdict::StructureLeft, "{finding:#?}");
    assert!(says(&finding, "is not white at the level of 1 %"), "{finding:#?}");
    let left = finding.left.iter().find(|left| left.is_memory()).unwrap();
    assert_eq!(left.drivers, ["time"]);
    assert!((0.1..0.6).contains(&left.share_of_residual_variance), "{left:?}");
    assert!(left.shape.starts_with("correlated over ") && left.shape.ends_with(" s"), "{left:?}");
}

#[test]
fn the_plain_model_that_leaves_such_a_memory_does_not_miss_nothing() {
    let told = Some(at_rest(0.0, 0.0));
    let finding = found(&at_rest(0.0, 0.0), told.clone());
    assert_eq!(finding.verdict, Verdict::NothingMissing, "{finding:#?}");
    let finding = found(&at_rest(0.0, 0.7), told);
    assert_eq!(finding.verdict, Verdict::StructureLeft, "{finding:#?}");
}

/// A memory that ends before the next reading is new in each: the error is not many times that noise.
#[test]
fn a_memory_shorter_than_the_time_between_readings_is_new_in_each() {
    let mut dataset = at_rest(0.0, 100.0);
    // One reading in fifty of the slow part.
    let keep = |values: &[f64]| values.iter().copied().step_by(50).collect::<Vec<f64>>();
    for column in &mut dataset.columns {
        column.values = keep(&column.values);
    }
    dataset.run_of_row = dataset.run_of_row.iter().copied().step_by(50).collect();
    let finding = found(&dataset, None);
    assert_eq!(finding.verdict, Verdict::NothingMissing, "{finding:#?}");
    assert!(finding.held_out.after < 1.5 * finding.noise_floor.value, "{finding:#?}");
}

/// A gyro at a table that ramps from one plateau to the next, half a sample late: only the ramps show the delay.
#[test]
fn a_delay_that_shows_in_ramps_alone_is_no_coloured_noise() {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(4);
    let plateau = |k: usize| 20.0 * ((k * 7 % 11) as f64 - 5.0);
    let rate = |t: f64| {
        let (k, into) = ((t / 60.0).floor() as usize, t.rem_euclid(60.0));
        let share = (into / 4.0).min(1.0);
        let before = if k == 0 { 0.0 } else { plateau(k - 1) };
        before + share * (plateau(k) - before)
    };
    let (mut time, mut gyro, mut truth) = (Vec::new(), Vec::new(), Vec::new());
    for row in 0..RUNS * ROWS {
        // Ramps begin and end at samples, so that straight lines between these are exact.
        let t = row as f64;
        let noise: f64 = StandardNormal.sample(&mut random);
        time.push(t);
        truth.push(rate(t));
        gyro.push(rate((t - 0.4).max(0.0)) + NOISE * noise);
    }
    let mut dataset = at_rest(0.0, 0.0);
    for column in &mut dataset.columns {
        match column.role {
            Role::ReferenceRate => column.values.clone_from(&truth),
            Role::Time => column.values.clone_from(&time),
            Role::GyroRate => column.values.clone_from(&gyro),
            _ => {}
        }
    }
    let finding = found(&dataset, None);
    let first = &finding.effects[0];
    assert_eq!(first.term, "delay", "{:?}", finding.effects);
    let chosen = finding.path.iter().find(|model| model.chosen).unwrap();
    let (plain, error) = (&finding.path[0].held_out["gyro"], &chosen.held_out["gyro"]);
    assert!(error.value < 2.0 * NOISE && plain.value > 1.0, "{:?}", finding.path);
}
