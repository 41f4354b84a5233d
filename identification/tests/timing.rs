//! Sensors that are late and have no other fault: by how much is said exactly, and nothing is said beside it.

use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::finding::{Finding, Verdict};
use identification::identify::{Options, identify};
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
