//! What is fed to a sensor warms it, and the error goes with the heat: with a lag behind the power or the square of the current.

use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::finding::{Effect, Verdict};
use identification::identify::{Identified, Options, identify};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

const RUNS: usize = 4;
const ROWS: usize = 400;
const NOISE: f64 = 0.01;
/// Error at full power, K, and time constant, s.
const SIZE: f64 = 0.3;
const LAG_S: f64 = 25.0;
/// What is fed is switched within a row.
const STEPS: usize = 10;

/// A thermistor that is fed at four levels in turn, each for up to a minute, beside a slow bath.
fn thermistor(unit: Unit, power: impl Fn(f64) -> f64) -> Dataset {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(5);
    let (mut time, mut bath, mut reads, mut fed) = (vec![], vec![], vec![], vec![]);
    let keep = (-1.0 / (STEPS as f64 * LAG_S)).exp();
    for run in 0..RUNS {
        let (mut level, mut until, mut heat) = (0.0, 0, 0.0);
        for step in 0..ROWS * STEPS {
            if step >= until {
                level = [0.0, 0.3, 0.6, 1.0][random.random_range(0..4)];
                until = step + random.random_range(5 * STEPS..60 * STEPS);
                heat = if step == 0 { power(level) } else { heat };
            }
            if step % STEPS == 0 {
                let t = (step / STEPS) as f64;
                let is = 40.0 + 15.0 * (t / (70.0 + 10.0 * run as f64) + run as f64).sin();
                let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
                time.push(t);
                bath.push(is);
                reads.push(1.004 * is - 0.15 + SIZE * heat + NOISE * draw());
                fed.push(level + 0.002 * draw());
            }
            heat = keep * heat + (1.0 - keep) * power(level);
        }
    }
    let columns = vec![
        Column::new("time", Role::Time, Unit::Second, time),
        Column::new("thermistor", Role::Measured, Unit::Celsius, reads),
        Column::new("bath", Role::Reference, Unit::Celsius, bath),
        Column::new("fed", Role::Auxiliary, unit, fed),
    ];
    let run = (0..RUNS * ROWS).map(|row| row / ROWS).collect();
    Dataset::new("thermistor", Kind::Sensor, columns, run)
}

fn found(unit: Unit, power: impl Fn(f64) -> f64) -> Identified {
    let dataset = thermistor(unit, power);
    identify(&dataset, None, &Options::default(), &mut |_, _| ()).unwrap()
}

/// Asserts that the value of the parameter, and not a part of it, was found.
fn assert_is(effect: &Effect, name: &str, value: f64) {
    let found = effect.parameters.iter().find(|one| one.name == name).unwrap();
    assert!((found.value / value - 1.0).abs() < 0.05, "{name}: {found:?}");
}

#[test]
fn heat_of_a_power_and_of_a_current_has_its_size_and_its_lag() {
    let [by_power, by_current] =
        [found(Unit::One, |power| power), found(Unit::Ampere, |current| current * current)];
    for (found, form, size, unit) in
        [(by_power, "linear", "slope", "K"), (by_current, "quadratic", "coefficient", "K/A^2")]
    {
        let finding = &found.finding;
        assert_eq!(finding.verdict, Verdict::Explained, "{:?}", finding.effects);
        let [effect] = &finding.effects[..] else { panic!("{:?}", finding.effects) };
        assert_eq!((&*effect.drivers[0], &*effect.form), ("lag_of(fed)", form));
        assert_is(effect, size, SIZE);
        assert_is(effect, "time_constant", LAG_S);
        assert_eq!(effect.parameters[0].unit, unit);
        // A firmware can take it off.
        let after = finding.compensation.as_ref().unwrap().held_out.after;
        assert!(after < 1.15 * NOISE, "{after}");
    }
}
