//! Sensors that are late and have no other fault: by how much is said exactly, and nothing is said beside it.

use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::finding::{Finding, Verdict};
use identification::identify::{Options, identify, predict};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal, Uniform};
use std::f64::consts::TAU;

/// Number of runs.
const RUNS: usize = 6;
const ROWS: usize = 6000;

/// A tone: its amplitude, frequency (1/s) and phase.
type Tone = [f64; 3];

fn tones(seed: u64, most: f64) -> Vec<Tone> {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
    let share = Uniform::new(0.0, 1.0).unwrap();
    let mut tone = || {
        let (frequency, phase) = (share.sample(&mut random), share.sample(&mut random));
        [10.0, most * (0.05 + 0.95 * frequency), TAU * phase]
    };
    (0..7).map(|_| tone()).collect()
}

/// Readings every `dt` of what a sensor makes of each tone at a time, with `noise`.
fn read(
    (kind, dt, noise): (Kind, f64, f64),
    (seed, most): (u64, f64),
    sensor: impl Fn(&Tone, f64) -> f64,
) -> Finding {
    let tones = tones(seed, most);
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed + 1000);
    let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
    let times: Vec<f64> = (0..ROWS).map(|row| row as f64 * dt).collect();
    let truth = |t: f64| tones.iter().map(|[a, f, p]| a * (TAU * f * t + p).sin()).sum::<f64>();
    let reading = |t: &f64| tones.iter().map(|tone| sensor(tone, *t)).sum::<f64>();
    let readings = times.iter().map(|t| reading(t) + noise * draw()).collect();
    let (roles, unit) = match kind {
        Kind::Series => ([Role::GyroRate, Role::ReferenceRate], Unit::DegreePerSecond),
        _ => ([Role::Measured, Role::Reference], Unit::Volt),
    };
    let columns = vec![
        Column::new("time", Role::Time, Unit::Second, times.clone()),
        Column::new("reading", roles[0], unit, readings),
        Column::new("truth", roles[1], unit, times.iter().map(|t| truth(*t)).collect()),
    ];
    let run = (0..ROWS).map(|row| row * RUNS / ROWS).collect();
    let dataset = Dataset::new("late", kind, columns, run);
    identify(&dataset, None, &Options::default(), &mut |_, _| ()).unwrap().finding
}

fn delayed(by: f64) -> impl Fn(&Tone, f64) -> f64 {
    move |[a, f, p], t| a * (TAU * f * (t - by) + p).sin()
}

/// The one effect, of this name and size (within `error`), and nothing left.
fn assert_only(finding: &Finding, name: &str, size: f64, error: f64) {
    let names: Vec<&str> = finding.effects.iter().map(|effect| effect.name.as_str()).collect();
    assert_eq!(names, [name], "{:?}", finding.effects);
    let found = finding.effects[0].parameters[0].value;
    assert!((found - size).abs() < error, "{found}");
    assert_eq!(
        (finding.verdict, &finding.left[..]),
        (Verdict::Explained, &[][..]),
        "{:?} {:?}",
        finding.effects,
        finding.held_out
    );
}

/// Between samples the reference is no straight line: what was left of one looked like waves of a bias.
#[test]
fn a_delay_shorter_than_a_sample_leaves_no_waves() {
    for seed in [31, 32] {
        let finding = read((Kind::Series, 0.05, 0.1), (seed, 1.4), delayed(0.02));
        assert_only(&finding, "delay", 0.02, 1e-4);
    }
}

/// A delay that is not quite at its best leaves an error, which looked like waves or a clock that is off.
#[test]
fn a_delay_of_some_samples_leaves_nothing() {
    let finding = read((Kind::Sensor, 0.05, 0.1), (33, 1.4), delayed(0.3));
    assert_only(&finding, "delay", 0.3, 1e-4);
}

#[test]
fn a_delay_of_many_samples_is_found_whatever_the_signal() {
    for (delay, most) in [(0.45, 1.4), (0.85, 1.4), (0.6, 0.12)] {
        let finding = read((Kind::Sensor, 0.05, 0.1), (34, most), delayed(delay));
        assert_only(&finding, "delay", delay, 2e-3);
        let error = finding.held_out.after;
        assert!(error < 0.105, "also in the first rows, whose reference is not there: {error}");
    }
}

/// A low-pass that is fast against the samples is not taken for a noisy reference, nor for a delay.
#[test]
fn a_low_pass_is_no_delay() {
    for (dt, constant, noise, most) in [(0.05, 0.02, 0.5, 1.4), (0.01, 0.004, 0.05, 5.0)] {
        let finding = read((Kind::Sensor, dt, noise), (35, most), |[a, f, p], t| {
            let angle = (TAU * f * constant).atan();
            a * angle.cos() * (TAU * f * t + p - angle).sin()
        });
        assert_only(&finding, "bandwidth", constant, 0.02 * constant);
        assert!(!finding.notices.iter().any(|one| one.contains("noisy itself")));
    }
}

/// All of what is measured is late, its scale error included: a delay of the truth alone came out wrong by that error.
#[test]
fn a_delay_beside_a_scale_error_is_as_long_as_it_is() {
    for (kind, by, gain, error) in [
        (Kind::Series, 0.02, 1.03, 1e-4),
        (Kind::Sensor, 0.3, 0.96, 5e-4),
        (Kind::Sensor, 0.85, 1.05, 2e-3),
    ] {
        let finding = read((kind, 0.05, 0.1), (51, 1.4), |tone, t| gain * delayed(by)(tone, t));
        assert_only(&finding, "delay", by, error);
        let base = finding.base.iter().find(|one| one.name == "scale_factor").unwrap();
        assert!((1.0 + base.value - gain).abs() < 3e-4, "{base:?}");
    }
}

/// What is measured, V or deg/s: two tones, levels that are held and left within two seconds, or slow tones.
fn measured(what: usize, t: f64) -> f64 {
    let level = |i: f64| 30.0 * (7.3 * i).sin() + 20.0 * (2.9 * i).cos();
    let (at, since) = ((t / 6.0).floor(), (t.rem_euclid(6.0) / 2.0).min(1.0));
    match what {
        0 => 50.0 + 30.0 * (t / 5.3).sin() + 14.0 * (t / 1.9).cos(),
        1 => level(at) + (level(at + 1.0) - level(at)) * since * since * (3.0 - 2.0 * since),
        _ => 50.0 + 30.0 * (t / 41.0).sin() + 14.0 * (t / 17.0).cos(),
    }
}

/// Five minutes, ten readings a second.
fn late(kind: Kind, what: usize, (by, gain, noise): (f64, f64, f64), seed: u64) -> Dataset {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
    let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
    let times: Vec<f64> = (0..3000).map(|row| f64::from(row) * 0.1).collect();
    let readings = times.iter().map(|t| 0.3 + gain * measured(what, t - by) + noise * draw());
    let (roles, unit) = match kind {
        Kind::Series => ([Role::GyroRate, Role::ReferenceRate], Unit::DegreePerSecond),
        _ => ([Role::Measured, Role::Reference], Unit::Volt),
    };
    let columns = vec![
        Column::new("time", Role::Time, Unit::Second, times.clone()),
        Column::new("reading", roles[0], unit, readings.collect()),
        Column::new("truth", roles[1], unit, times.iter().map(|t| measured(what, *t)).collect()),
    ];
    Dataset::new("late", kind, columns, vec![0; times.len()])
}

/// It was a wave of the bias, an error over the slope of the reference, noise of the reference, or a clock that is off by 2 %.
#[test]
fn a_delay_of_seconds_is_no_wave_and_no_noise_of_the_reference() {
    for (kind, what, delay, noise, error) in [
        (Kind::Sensor, 0, 4.03, 1.0, 0.01),
        (Kind::Sensor, 1, 4.0, 1.0, 0.03),
        (Kind::Sensor, 2, 4.0, 0.1, 0.03),
        (Kind::Series, 0, 4.0, 0.1, 1e-3),
        (Kind::Series, 2, -4.03, 0.1, 0.03),
    ] {
        let dataset = late(kind, what, (delay, 1.0, noise), 77);
        let found = identify(&dataset, None, &Options::default(), &mut |_, _| ()).unwrap().finding;
        assert_only(&found, "delay", delay, error);
        assert!(!found.notices.iter().any(|one| one.contains("noisy itself")), "{kind:?} {what}");
    }
}

/// Also in what is applied to other data.
#[test]
fn a_model_with_a_delay_and_a_scale_error_predicts_both() {
    let [one, other] = [78, 79].map(|seed| late(Kind::Sensor, 1, (4.03, 1.05, 0.1), seed));
    let model = identify(&one, None, &Options::default(), &mut |_, _| ()).unwrap().model;
    let predicted = predict(&other, &model).unwrap();
    // The first rows have no reference.
    let left = &predicted.residual[60..];
    let error = (left.iter().map(|one| one * one).sum::<f64>() / left.len() as f64).sqrt();
    assert!(error < 0.12, "{error}");
}

/// A staircase, up and down, with a hysteresis below the noise of a reading. The hundredth of the readings that seemed to come a row
/// late was written down as a delay of 12 ms, and such a model made predictions worse than none (in 13 of 60 such sets).
#[test]
fn what_a_finding_promises_is_what_its_model_gives() {
    for seed in 0..20 {
        let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
        let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
        let (mut times, mut truth, mut readings, mut run) = (vec![], vec![], vec![], vec![]);
        for cycle in 0..6 {
            for row in 0..126 {
                let step = row / 6;
                let (level, up) = if step <= 10 { (step, 1.0) } else { (20 - step, -1.0) };
                let level = f64::from(level);
                let bow = 0.4 * level * (1.0 - level / 10.0) / 2.0;
                times.push(2.0 * f64::from(row));
                truth.push(level);
                readings.push(0.015 + 1.004 * level - 0.003 * up * bow + 0.002 * draw());
                run.push(cycle);
            }
        }
        let columns = vec![
            Column::new("time", Role::Time, Unit::Second, times),
            Column::new("reading", Role::Measured, Unit::One, readings),
            Column::new("truth", Role::Reference, Unit::One, truth),
        ];
        let dataset = Dataset::new("staircase", Kind::Sensor, columns, run);
        let found = identify(&dataset, None, &Options::default(), &mut |_, _| ()).unwrap();
        let promised = found.finding.held_out.after;
        let given = predict(&dataset, &found.model).unwrap().rmse.after;
        assert!(given < 1.1 * promised, "{seed}: {promised} {given} {:?}", found.finding.effects);
    }
}
