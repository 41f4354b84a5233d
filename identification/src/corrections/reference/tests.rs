use super::fit::{Stretch, width};
use crate::signal::{first_order, interpolate};
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
