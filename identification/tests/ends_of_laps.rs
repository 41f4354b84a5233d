//! Ends of laps round a square: heading, x and y are readings of one error over a lever.

use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::identify::{Identified, Options, identify};
use identification::model::Model;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const LAPS: usize = 80;
/// Half a side, m.
const LEVER_M: f64 = 2.0;
/// Noise of a heading, rad, and of a coordinate, m.
const HEADING: f64 = 0.003;
const POSITION: f64 = 0.006;

/// Laps whose odometry turns too far by `curvature` (rad in each lap), in either direction.
fn laps(curvature: &[f64], seed: u64) -> Dataset {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
    let mut noise = |size: f64| -> Vec<f64> {
        let draw = |_| {
            let z: f64 = StandardNormal.sample(&mut random);
            size * z
        };
        (0..LAPS).map(draw).collect()
    };
    let direction: Vec<f64> = (0..LAPS).map(|lap| if lap % 2 == 0 { 1.0 } else { -1.0 }).collect();
    let row = |value: &dyn Fn(usize) -> f64| (0..LAPS).map(value).collect::<Vec<f64>>();
    let plus = |noise: Vec<f64>, by: f64| -> Vec<f64> {
        noise.iter().zip(curvature).map(|(n, curvature)| n + by * curvature).collect()
    };
    let along = |noise: Vec<f64>| -> Vec<f64> {
        let shifted = noise.iter().zip(&direction).zip(curvature);
        shifted.map(|((n, direction), curvature)| n + direction * LEVER_M * curvature).collect()
    };
    let gyro = {
        let noise = noise(0.05);
        noise.iter().zip(&direction).map(|(n, direction)| direction * 360.0 + n).collect()
    };
    Dataset::new(
        "laps",
        Kind::Laps,
        vec![
            Column::new("time", Role::Time, Unit::Second, row(&|lap| 100.0 * lap as f64)),
            Column::new("direction", Role::Direction, Unit::One, direction.clone()),
            Column::new("gyro_angle", Role::GyroAngle, Unit::Degree, gyro),
            Column::new("odometry_x", Role::OdometryX, Unit::Metre, vec![0.0; LAPS]),
            Column::new("odometry_y", Role::OdometryY, Unit::Metre, vec![0.0; LAPS]),
            Column::new("odometry_heading", Role::OdometryHeading, Unit::Radian, vec![0.0; LAPS]),
            Column::new("reference_x", Role::ReferenceX, Unit::Metre, along(noise(POSITION))),
            Column::new(
                "reference_y",
                Role::ReferenceY,
                Unit::Metre,
                plus(noise(POSITION), -LEVER_M),
            ),
            Column::new(
                "reference_heading",
                Role::ReferenceHeading,
                Unit::Radian,
                plus(noise(HEADING), 1.0),
            ),
            Column::new(
                "temperature",
                Role::Temperature,
                Unit::Celsius,
                row(&|lap| 25.0 + 5.0 * (lap as f64 / 13.0).sin()),
            ),
            Column::new("duration", Role::Duration, Unit::Second, vec![64.0; LAPS]),
        ],
        (0..LAPS).map(|lap| lap / 4).collect(),
    )
}

fn identified(laps: &Dataset, model: Option<&Model>) -> Identified {
    identify(laps, model, &Options::default(), &mut |_, _| {}).unwrap()
}

/// A slow error that nothing explains: a first-order Gauss-Markov process of ten laps.
fn slow(size: f64, seed: u64) -> Vec<f64> {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
    let keep = (-0.1_f64).exp();
    let mut state = 0.0;
    (0..LAPS)
        .map(|_| {
            let z: f64 = StandardNormal.sample(&mut random);
            state = keep * state + size * (1.0 - keep * keep).sqrt() * z;
            state
        })
        .collect()
}

/// The lever is known from elsewhere, and the plain model has no term that acts on it.
#[test]
fn slow_noise_over_a_known_lever_has_a_finding() {
    let large = identified(&laps(&[0.05; LAPS], 1), None);
    let lever = large.model.closing_lever_m.unwrap();
    assert!((lever / LEVER_M - 1.0).abs() < 0.1, "{lever}");
    let nothing = Model { terms: Vec::new(), plain: Vec::new(), ..large.model };
    let mut coloured = 0;
    for seed in 0..8 {
        let found = identified(&laps(&slow(0.002, seed), seed), Some(&nothing));
        let is_coloured = found.diagnostics.blocks.iter().any(|block| block.noise.len() > 1);
        coloured += usize::from(is_coloured && found.finding.effects.is_empty());
    }
    assert!(coloured > 0, "some of it is taken for coloured noise and nothing else");
}

/// The plain model has no constant for the odometry, so that an effect is zero where a constant puts it.
#[test]
fn an_effect_of_temperature_brings_the_constant_that_says_where_it_is_zero() {
    let celsius = |lap: usize| 25.0 + 5.0 * (lap as f64 / 13.0).sin();
    for seed in 0..8 {
        let curvature: Vec<f64> = (0..LAPS).map(|lap| 5e-4 * (celsius(lap) - 17.0)).collect();
        let finding = identified(&laps(&curvature, seed), None).finding;
        let mut found: Vec<String> = finding
            .effects
            .iter()
            .filter(|effect| ["turn", "curvature", "drive"].contains(&effect.term.as_str()))
            .map(|effect| format!("{}: {}", effect.term, effect.drivers.join(" + ")))
            .collect();
        found.sort_unstable();
        assert_eq!(found, ["curvature: ", "curvature: temperature"], "{seed}");
    }
}
