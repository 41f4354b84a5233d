//! The yaw rate of a car that comes late: its driver turns so slowly that to first order a delay and a low-pass are the same.

use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::finding::Finding;
use identification::identify::{Options, identify};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

const ROWS: usize = 9000;
const STEP: f64 = 0.01;

/// How the sensor comes by its reading.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Late {
    Delay,
    LowPass,
}

/// A drive of 90 s at 100 Hz: bends of some seconds each, with a yaw rate of up to 25 deg/s. Beside white noise of a fifth, the noise
/// forgets within 0.3 s.
fn drive((late, by): (Late, f64), noise: f64, seed: u64) -> Finding {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
    let bends: Vec<[f64; 3]> = (0..14)
        .map(|bend| {
            let middle = 90.0 * (f64::from(bend) + random.random::<f64>()) / 14.0;
            [middle, 1.0 + 1.5 * random.random::<f64>(), 50.0 * (random.random::<f64>() - 0.5)]
        })
        .collect();
    let rate = |t: f64| -> f64 {
        bends.iter().map(|[at, width, size]| size * (-0.5 * ((t - at) / width).powi(2)).exp()).sum()
    };
    let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
    let keep = f64::exp(-STEP / 0.3);
    let (mut slow, mut low_pass) = (draw(), rate(-5.0));
    let mut columns: [Vec<f64>; 3] = Default::default();
    // Ten steps of the low-pass a row.
    let fine = STEP / 10.0;
    for step in -5000..10 * ROWS as i64 {
        let t = fine * step as f64;
        low_pass += (rate(t - fine / 2.0) - low_pass) * (1.0 - (-fine / by).exp());
        if step < 0 || step % 10 != 0 {
            continue;
        }
        slow = keep * slow + (1.0 - keep * keep).sqrt() * draw();
        let seen = if late == Late::Delay { rate(t - by) } else { low_pass };
        let values = [t, 0.1 + 0.99 * seen + noise * (slow + 0.2 * draw()), rate(t)];
        columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
    }
    let named = [
        ("time", Role::Time, Unit::Second),
        ("yaw_rate", Role::GyroRate, Unit::DegreePerSecond),
        ("reference", Role::ReferenceRate, Unit::DegreePerSecond),
    ];
    let columns = named.into_iter().zip(columns);
    let columns = columns.map(|((name, role, unit), v)| Column::new(name, role, unit, v)).collect();
    let dataset = Dataset::new("drive", Kind::Series, columns, vec![0; ROWS]);
    identify(&dataset, None, &Options::default(), &mut |_, _| ()).unwrap().finding
}

/// The first effect and the rivals of it that are late.
fn named(finding: &Finding) -> (&str, Vec<&str>) {
    let Some(first) = finding.effects.first() else { return ("", Vec::new()) };
    let rivals = first.rivals.iter().map(|rival| rival.name.as_str());
    let late = rivals.filter(|name| ["delay", "bandwidth"].contains(name));
    (&first.name, late.collect())
}

#[test]
fn a_late_yaw_rate_is_a_delay_with_the_low_pass_as_its_rival() {
    for (seed, by, noise) in [(1, 0.02, 0.03), (3, 0.05, 0.1), (5, 0.08, 0.03)] {
        assert_eq!(named(&drive((Late::Delay, by), noise, seed)), ("delay", vec!["bandwidth"]));
    }
}

/// To second order they are not the same: with the same mean delay they differ by half its square times the second derivative, here
/// by up to 0.5 deg/s for 0.3 s.
#[test]
fn a_slow_yaw_rate_is_a_low_pass_where_the_noise_tells() {
    for seed in [1, 2] {
        for by in [0.3, 0.5] {
            assert_eq!(named(&drive((Late::LowPass, by), 0.03, seed)), ("bandwidth", vec![]));
        }
        assert_eq!(named(&drive((Late::Delay, 0.3), 0.03, seed)), ("delay", vec![]));
        assert_eq!(named(&drive((Late::LowPass, 0.05), 0.1, seed)), ("delay", vec!["bandwidth"]));
    }
}
