//! Effects with a zero off the middle of the data: each part explains little without the others.

use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::finding::{Finding, Verdict};
use identification::identify::{Options, identify};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const RUNS: usize = 8;
const ROWS: usize = 60;
/// Interval between readings, s.
const INTERVAL_S: f64 = 30.0;
/// Noise of a reading, deg/s.
const NOISE: f64 = 1e-3;

/// A gyro at rest, warmed and cooled between 23 and 47 degC, with `bias` (deg/s) over temperature and time (h).
fn found(bias: impl Fn(f64, f64) -> f64) -> Finding {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(17);
    let (mut time, mut temperature, mut gyro) = (Vec::new(), Vec::new(), Vec::new());
    for row in 0..RUNS * ROWS {
        let t = INTERVAL_S * row as f64;
        let celsius = 35.0 + 12.0 * (t / 700.0).sin();
        let noise: f64 = StandardNormal.sample(&mut random);
        time.push(t);
        temperature.push(celsius);
        gyro.push(0.02 + bias(celsius, t / 3600.0) + NOISE * noise);
    }
    let dataset = Dataset::new(
        "chamber",
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
            Column::new("temperature", Role::Temperature, Unit::Celsius, temperature),
        ],
        (0..RUNS * ROWS).map(|row| row / ROWS).collect(),
    );
    identify(&dataset, None, &Options::default(), &mut |_, _| {}).unwrap().finding
}

#[track_caller]
fn is_explained_by(finding: &Finding, names: &[&str]) {
    let mut found: Vec<&str> = finding.effects.iter().map(|effect| effect.name.as_str()).collect();
    found.sort_unstable();
    assert_eq!(found, names, "{:#?}", finding.path);
    assert_eq!(finding.verdict, Verdict::Explained, "{:?}", finding.left);
    assert!(finding.held_out.after < 1.2 * NOISE, "{:?}", finding.held_out);
}

/// Neither a line nor a parabola about the middle explains much of it.
#[test]
fn a_parabola_about_the_end_of_the_range_is_one() {
    let finding = found(|celsius, _| 5e-4 * (celsius - 25.0).powi(2));
    is_explained_by(&finding, &["bias_over_temperature"]);
    assert_eq!(finding.effects[0].form, "quadratic");
}

/// A coefficient that was correct at power-up.
#[test]
fn a_coefficient_that_ages_is_one() {
    let finding = found(|celsius, hours| 1e-3 * (celsius - 25.0) * hours);
    is_explained_by(
        &finding,
        &["bias_ageing", "bias_over_temperature", "bias_over_temperature_and_time"],
    );
}
