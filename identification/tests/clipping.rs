//! Clipped readings are reported with their limits, and do not hide other effects.

use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::finding::{Finding, Verdict};
use identification::identify::{Identified, Options, identify, predict};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const RUNS: usize = 6;
const ROWS: usize = 600;
const SIGMA: f64 = 0.05;
/// What the sensor does within its range.
const SCALE: f64 = 1.002;
const BIAS: f64 = 0.1;

/// Six records of a sensor whose reference swings by 17 about `middle`. `range` maps the reference to the reading; the
/// coloured noise keeps the share `keep` of itself.
fn dataset(
    kind: Kind,
    thermal: f64,
    range: impl Fn(f64) -> f64,
    (keep, seed): (f64, u64),
) -> Dataset {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let middle = if kind == Kind::Sensor { 20.0 } else { 0.0 };
    let (mut time, mut truth, mut warm, mut reads) = (vec![], vec![], vec![], vec![]);
    let mut slow = 0.0;
    for row in 0..RUNS * ROWS {
        let (run, at) = (row / ROWS, (row % ROWS) as f64);
        let phase = at + 31.0 * run as f64;
        let x = middle + 12.0 * (phase / 23.0).sin() + 6.0 * (phase / 61.0).cos();
        let celsius = 25.0 + 10.0 * (phase / 400.0).sin() + 1.5 * run as f64;
        slow = keep * slow + normal() * SIGMA;
        time.push(4000.0 * run as f64 + at);
        truth.push(x);
        warm.push(celsius);
        reads.push(range(SCALE * x + BIAS + thermal * (celsius - 25.0) + slow));
    }
    let (measured, reference, unit) = match kind {
        Kind::Sensor => (Role::Measured, Role::Reference, Unit::Ampere),
        _ => (Role::GyroRate, Role::ReferenceRate, Unit::DegreePerSecond),
    };
    Dataset::new(
        "bench",
        kind,
        vec![
            Column::new("time", Role::Time, Unit::Second, time),
            Column::new("reads", measured, unit, reads),
            Column::new("truth", reference, unit, truth),
            Column::new("warmth", Role::Temperature, Unit::Celsius, warm),
        ],
        (0..RUNS * ROWS).map(|row| row / ROWS).collect(),
    )
}

fn found(dataset: &Dataset) -> Identified {
    identify(dataset, None, &Options::default(), &mut |_, _| ()).unwrap()
}

fn names(finding: &Finding) -> Vec<&str> {
    finding.effects.iter().map(|effect| effect.name.as_str()).collect()
}

#[test]
fn a_range_is_found_with_its_limits_and_hides_no_other_cause() {
    let cases = [
        (Kind::Series, -15.0, 15.0),
        (Kind::Series, -12.0, 16.0),
        (Kind::Series, f64::NEG_INFINITY, 8.0),
        (Kind::Sensor, f64::NEG_INFINITY, 33.0),
        (Kind::Sensor, 5.0, 34.0),
    ];
    for (kind, low, high) in cases {
        let data = dataset(kind, 0.01, |reads| reads.clamp(low, high), (0.0, 7));
        let found = found(&data);
        assert_eq!(names(&found.finding), ["saturation", "bias_over_temperature"], "{low} {high}");
        assert_eq!(found.finding.verdict, Verdict::Explained);
        // The reference at which the reading reaches its limit, at the mean temperature of those readings.
        let effect = &found.finding.effects[0];
        for (name, limit) in [("limit", high), ("lower_limit", low)] {
            let told = effect.parameters.iter().find(|one| one.name == name);
            if limit.is_finite() {
                let off = told.unwrap().value - (limit - BIAS) / SCALE;
                assert!(off.abs() < 0.25, "{name} {told:?}");
            } else {
                assert!(told.is_none_or(|one| one.standard_error.is_none()), "{told:?}");
            }
        }
        let held_out = &found.finding.held_out;
        assert!(held_out.after < 1.1 * SIGMA && held_out.before > 3.0 * SIGMA, "{held_out:?}");
        assert!(effect.held_out_before > 3.0 * SIGMA);
        assert_eq!(found.finding.path[0].effects.len(), 0);
        let told = predict(&data, &found.model).unwrap().rmse;
        assert!(told.after < 1.2 * SIGMA && told.before > 3.0 * SIGMA, "{told:?}");
    }
}

#[test]
fn a_range_that_is_not_reached_is_none() {
    for seed in 0..4 {
        for keep in [0.0, 0.9] {
            let data = dataset(Kind::Series, 0.0, |reads| reads.clamp(-18.0, 18.0), (keep, seed));
            assert_eq!(names(&found(&data).finding), Vec::<&str>::new(), "{seed} {keep}");
        }
    }
}

/// Rounding steps are flat too, and no reading lies beyond the last one.
#[test]
fn the_last_step_of_a_coarse_reading_is_no_limit() {
    let step = 4.0 * SIGMA;
    let data = dataset(Kind::Series, 0.0, |reads| (reads / step).round() * step, (0.0, 3));
    assert_eq!(names(&found(&data).finding), ["rounding"]);
}

/// Readings of a sensor of a range of 12 V whose noise comes after it, as that of a converter does; it keeps that share of itself.
fn noisy_after(keep: f64, seed: u64) -> (f64, Finding) {
    let mut draw = crate::intervals::noise(seed);
    let limit = 12.0 + 0.01 * seed as f64;
    let course = |at: f64| 11.0 * (at / 23.0).sin() + 6.0 * (at / 61.0).cos();
    let truth: Vec<f64> = (0..RUNS * ROWS).map(|row| course(row as f64)).collect();
    let mut slow = 0.0;
    let reads = truth.iter().map(|x| {
        slow = keep * slow + (1.0 - keep * keep).sqrt() * draw();
        (SCALE * x + BIAS).min(limit) + SIGMA * slow
    });
    let columns = vec![
        Column::new("time", Role::Time, Unit::Second, (0..truth.len()).map(|t| t as f64).collect()),
        Column::new("reads", Role::Measured, Unit::Volt, reads.collect()),
        Column::new("truth", Role::Reference, Unit::Volt, truth.clone()),
    ];
    let run = (0..truth.len()).map(|row| row / ROWS).collect();
    let dataset = Dataset::new("after", Kind::Sensor, columns, run);
    ((limit - BIAS) / SCALE, found(&dataset).finding)
}

/// The error was that of a mean of independent readings beside a line that is known.
#[test]
fn the_interval_of_a_limit_holds_where_noise_comes_after_it() {
    for keep in [0.0, 0.9] {
        let findings: Vec<(f64, Finding)> =
            (0..crate::intervals::SETS).map(|seed| noisy_after(keep, 40 + seed)).collect();
        let all: Vec<_> = findings
            .iter()
            .map(|(limit, one)| (*limit, crate::intervals::parameter(one, "saturation", "limit")))
            .collect();
        crate::intervals::assert_held(&all, 0.02);
    }
}
