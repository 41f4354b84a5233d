use super::fit::{Stretch, width};
use crate::corrections::{Correction, Fault, applied};
use crate::dataset::{Column, Dataset, Kind, Role, Unit};
use crate::model::{Acts, Driver, Form, Shape, Wrap, is_physical};
use crate::problem::{Known, Problem};
use crate::signal::{bends, interpolate};
use chacha20::ChaCha8Rng;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const STEP: f64 = 0.01;

/// A load that moves as a smoothed random walk, read with noise of 1 through `sensor`, beside a reference with that noise.
fn record(seed: u64, noise: f64, sensor: impl Fn(&[f64], &[f64]) -> Vec<f64>) -> Vec<Stretch> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = move || -> f64 { StandardNormal.sample(&mut random) };
    (0..4)
        .map(|_| {
            let times: Vec<f64> = (0..2500).map(|row| f64::from(row) * STEP).collect();
            let mut at = 0.0;
            let walk: Vec<f64> = times
                .iter()
                .map(|time| {
                    // Every third second at rest.
                    at += if (time % 3.0) < 2.0 { 2.0 * normal() } else { 0.0 };
                    at
                })
                .collect();
            let truth = first_order(&times, &first_order(&times, &walk, 0.1), 0.1);
            let readings = sensor(&times, &truth).into_iter().map(|value| value + normal());
            let readings = readings.collect();
            let reference = truth.iter().map(|value| value + noise * normal()).collect();
            Stretch { times, reference, readings }
        })
        .collect()
}

fn first_order(times: &[f64], values: &[f64], constant: f64) -> Vec<f64> {
    crate::signal::first_order(times, values, &bends(times, values), constant)
}

fn late(times: &[f64], truth: &[f64], by: f64) -> Vec<f64> {
    times.iter().map(|time| interpolate(times, truth, time - by)).collect()
}

#[test]
fn noise_of_the_reference_is_evened_out_and_nothing_else_is() {
    for seed in 0..3 {
        let plain = |noise| width(&record(seed, noise, |_, truth| truth.to_vec()));
        assert_eq!(plain(0.0), None);
        for noise in [0.3, 1.0] {
            let found = plain(noise).expect("it is noisy");
            assert!((0.3 * STEP..0.3).contains(&found), "{found}");
        }
        // What a sensor does itself is left to it.
        let lag = |times: &[f64], truth: &[f64]| first_order(times, truth, 0.05);
        assert_eq!(width(&record(seed, 0.0, lag)), None);
        assert_eq!(width(&record(seed, 0.0, |times, truth| late(times, truth, 0.023))), None);
        let clipped = |_: &[f64], truth: &[f64]| {
            truth.iter().map(|value| value.clamp(-20.0, 20.0)).collect::<Vec<f64>>()
        };
        assert_eq!(width(&record(seed, 0.0, clipped)), None);
        let bent = |_: &[f64], truth: &[f64]| {
            truth.iter().map(|value| value + 2e-3 * value * value).collect::<Vec<f64>>()
        };
        assert_eq!(width(&record(seed, 0.0, bent)), None);
        // Beside a lag the noise is seen all the same.
        assert!(width(&record(seed, 1.0, lag)).is_some());
    }
}

/// What stays of it no longer looks like noise, and a play as narrow would even it out further.
#[test]
fn the_noise_of_a_reference_is_known_after_it_is_evened_out() {
    let noise = 0.3;
    let Stretch { times, reference, readings } =
        record(5, noise, |_, truth| truth.to_vec()).remove(0);
    let rows = times.len();
    let columns = vec![
        Column::new("time", Role::Time, Unit::Second, times),
        Column::new("reads", Role::Measured, Unit::Ampere, readings),
        Column::new("truth", Role::Reference, Unit::Ampere, reference),
    ];
    let dataset = Dataset::new("any", Kind::Sensor, columns, vec![0; rows]);
    let evened = Correction {
        fault: Fault::ReferenceNoise,
        field: "truth".to_owned(),
        value: 0.05,
        unit: Unit::Second,
        standard_error: None,
    };
    let right = applied(&dataset, &[evened]);
    let channels = Problem::new(&right, Known::default()).expect("a whole set").channels;
    assert!((channels.rotation_noise / noise - 1.0).abs() < 0.15, "{}", channels.rotation_noise);
    let play = |half: f64| {
        Shape::new("hysteresis", Acts::Bias, Driver::new(Wrap::BranchOf, "truth"), Form::Linear)
            .with("half_width", half)
    };
    assert!(!is_physical(&play(5.0 * noise), &channels, &[], &[]));
    assert!(is_physical(&play(8.0 * noise), &channels, &[], &[]));
}
