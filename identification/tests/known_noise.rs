//! Errors of a sensor that no model of a single reading takes away, and that are known all the same: they are named, and
//! nothing else is.

use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::finding::{Finding, Verdict};
use identification::identify::{Options, identify};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const ROWS: usize = 4800;

/// Readings of a voltage between 6 and 94 V, ten a second, in this many runs; `error` is that of a reading of the truth in a
/// run with two draws of the noise, one of the reading and one of the run.
fn found(runs: usize, seed: u64, error: impl Fn(f64, f64, [f64; 2]) -> f64) -> Finding {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
    let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
    let of_run: Vec<f64> = (0..runs).map(|_| draw()).collect();
    let (mut time, mut truth, mut room, mut read) = (vec![], vec![], vec![], vec![]);
    for row in 0..ROWS {
        let t = row as f64 * 0.1;
        let (x, warm) = (50.0 + 30.0 * (t / 5.3).sin() + 14.0 * (t / 1.9).cos(), (t / 31.0).sin());
        time.push(t);
        truth.push(x);
        room.push(20.0 + 9.0 * warm);
        read.push(error(x, warm, [draw(), of_run[row * runs / ROWS]]));
    }
    let columns = vec![
        Column::new("time", Role::Time, Unit::Second, time),
        Column::new("read", Role::Measured, Unit::Volt, read),
        Column::new("truth", Role::Reference, Unit::Volt, truth),
        Column::new("room", Role::Temperature, Unit::Celsius, room),
    ];
    let run = (0..ROWS).map(|row| row * runs / ROWS).collect();
    let dataset = Dataset::new("sensor", Kind::Sensor, columns, run);
    identify(&dataset, None, &Options::default(), &mut |_, _| ()).unwrap().finding
}

fn names(finding: &Finding) -> Vec<&str> {
    finding.effects.iter().map(|effect| effect.name.as_str()).collect()
}

#[test]
fn an_offset_of_each_run_is_no_random_walk_and_not_nothing() {
    for (runs, seed) in [(8, 41), (48, 42)] {
        let finding = found(runs, seed, |x, _, [z, run]| x + 0.3 * run + 0.05 * z);
        assert_eq!(names(&finding), ["offset_of_runs"], "{:?}", finding.effects);
        let size = &finding.effects[0].parameters[0];
        let error = size.standard_error.unwrap();
        assert!((size.value - 0.3).abs() < 3.0 * error, "{size:?}");
        assert_eq!(finding.verdict, Verdict::NothingMissing, "{:?}", finding.left);
        assert!(finding.in_words()[0].contains("differs from run to run by 0."));
    }
}

/// What wanders within its runs as well is not called an offset of a run, nor is noise.
#[test]
fn what_wanders_and_what_is_noise_have_no_offset_of_a_run() {
    let walk = std::cell::Cell::new(0.0);
    let walks = found(12, 43, |x, _, [z, _]| {
        walk.set(walk.get() + 0.02 * (1e3 * x + 7.0 * z).sin());
        x + walk.get() + 0.05 * z
    });
    assert!(!names(&walks).contains(&"offset_of_runs"), "{:?}", walks.effects);
    for seed in 44..48 {
        let noise = found(12, seed, |x, _, [z, _]| x + 0.05 * z);
        assert_eq!(names(&noise), [""; 0], "{:?}", noise.effects);
    }
}

#[test]
fn an_ideal_converter_rounds_and_does_nothing_else() {
    let finding = found(6, 45, |x, _, [z, _]| ((x + 0.02 * z) / 0.4).round() * 0.4);
    assert_eq!(names(&finding), ["rounding"], "{:?}", finding.effects);
    assert_eq!(finding.verdict, Verdict::NothingMissing, "{:?}", finding.left);
    let said = finding.in_words();
    assert!(!said.iter().any(|one| one.contains("times the noise")), "{said:?}");
}

#[test]
fn what_is_clipped_is_left_out_of_a_compensation_or_there_is_none() {
    let clipped = found(6, 46, |x, _, [z, _]| x.min(80.0) + 0.05 * z);
    assert_eq!(names(&clipped), ["saturation"], "{:?}", clipped.effects);
    assert_eq!(clipped.compensation, None, "gains nothing");
    let offset = found(6, 46, |x, _, [z, _]| x.min(80.0) + 8.0 + 0.05 * z);
    let compensation = offset.compensation.unwrap();
    assert!(compensation.left_out.iter().any(|one| one.term == "saturation"), "{compensation:?}");
}

/// Of a voltage that is never negative, the direction is no second cause.
#[test]
fn a_cause_has_no_rival_that_is_itself() {
    let finding = found(6, 47, |x, warm, [z, _]| x * (1.0 + 4e-3 * warm) + 0.05 * z);
    assert_eq!(names(&finding), ["scale_over_temperature"], "{:?}", finding.effects);
    assert_eq!(finding.effects[0].rivals, [], "{:?}", finding.effects[0].rivals);
}
