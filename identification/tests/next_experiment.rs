//! From data to the plan that decides between causes.

use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::identify::{Identified, Options, identify};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const RUNS: usize = 150;

/// Table runs of 48 s in one warm-up from 22 to 40 degC, with a bias of `size` deg/s per K.
fn warm_up(size: f64) -> Identified {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(11);
    let mut values: [Vec<f64>; 6] = Default::default();
    let mut run_of_row = Vec::new();
    for run in 0..RUNS {
        for (turn, direction) in [-1.0, 1.0].into_iter().enumerate() {
            let time = 48.0 * run as f64 + 34.0 + 14.0 * turn as f64;
            let warmth = 18.0 * (1.0 - (-time / 2100.0_f64).exp());
            let noise: f64 = StandardNormal.sample(&mut random);
            let error = 14.0 * size * warmth + 0.01 * noise;
            let row = [
                time,
                direction,
                360.0 * direction + error,
                360.0 * direction,
                22.0 + warmth,
                14.0,
            ];
            values.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
            run_of_row.push(run);
        }
    }
    let fields = [
        ("time", Role::Time, Unit::Second),
        ("direction", Role::Direction, Unit::One),
        ("gyro_angle", Role::GyroAngle, Unit::Degree),
        ("reference_angle", Role::ReferenceAngle, Unit::Degree),
        ("temperature", Role::Temperature, Unit::Celsius),
        ("duration", Role::Duration, Unit::Second),
    ];
    let columns = fields
        .into_iter()
        .zip(values)
        .map(|((name, role, unit), values)| Column::new(name, role, unit, values))
        .collect();
    let dataset = Dataset::new("warm-up", Kind::Turns, columns, run_of_row);
    identify(&dataset, None, &Options::default(), &mut |_, _| ()).unwrap()
}

#[test]
fn what_one_warm_up_leaves_in_doubt_is_to_be_decided() {
    let found = warm_up(5e-4);
    let effect =
        found.finding.effects.first().expect("a drift of 0.1 deg in 0.01 deg of noise is seen");
    assert!(
        !effect.rivals.is_empty(),
        "temperature, its rate and time are one in a warm-up: {effect:?}"
    );
    let next = found.finding.next_experiment.as_ref().unwrap();
    let experiment = found.experiment.as_ref().unwrap();
    assert_eq!(next.plan, experiment.file());
    assert_eq!(next.separates[0], effect.name);
    assert!(next.separates.len() > 1 && next.expected_gain.contains("lambda"), "{next:?}");
    assert!(
        effect.rivals.iter().any(|rival| rival.separated_by.as_ref() == Some(&next.plan)),
        "{effect:?}"
    );
    assert!(experiment.plan_toml.starts_with(&format!("# Tells apart: {}", effect.name)));
    assert!(experiment.plan_toml.contains(&format!("name = \"{}\"", experiment.name)));
}

#[test]
fn where_nothing_is_in_doubt_nothing_is_proposed() {
    let found = warm_up(0.0);
    assert!(found.finding.effects.is_empty() && found.experiment.is_none());
    assert!(found.finding.next_experiment.is_none());
}
