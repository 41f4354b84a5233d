//! Scale, bias, range and noise.

use super::{NAVIGATOR, gyro, rate, run, table_turn};
use crate::gyro::{GyroEmulator, GyroParameters};
use proptest::prelude::*;
use wire::units::Angle;

/// Eq. 5: E_T = -0.52 T + 19.23 deg for 360 deg, clockwise and counter-clockwise alike.
#[test]
fn the_papers_scale_gives_equation_5() {
    for celsius in [20.0, 25.0, 31.0, 36.98, 42.0] {
        for direction in [-1.0, 1.0] {
            let mut gyro = gyro(
                GyroParameters {
                    ambient_celsius: celsius,
                    scale_ppm_per_kelvin: -0.52 / 360.0 * 1e6,
                    scale_zero_celsius: 19.23 / 0.52,
                    bandwidth_hz: 100.0,
                    range_deg_per_s: 100.0,
                    ..Default::default()
                },
                NAVIGATOR,
            );
            let mut turned = 0.0;
            run(&mut gyro, 16.0, table_turn(direction), |sample| turned += rate(sample) * 0.01);
            let error = direction * turned - 360.0;
            assert!((error - (-0.52 * celsius + 19.23)).abs() < 1e-9, "{celsius}: {error}");
        }
    }
}

#[test]
fn beyond_the_range_the_data_are_wrong_and_the_validity_stays_good() {
    let parameters = GyroParameters { range_deg_per_s: 100.0, ..Default::default() };
    for (true_rate, shown, over) in
        [(99.0, 99.0, false), (150.0, 100.0, true), (-101.0, -100.0, true)]
    {
        let mut gyro = gyro(parameters.clone(), NAVIGATOR);
        run(
            &mut gyro,
            1.0,
            |t| Angle::from_deg(true_rate * t),
            |sample| {
                assert!((rate(sample) - shown).abs() < 1e-9);
                assert_eq!((sample.status.over_range, sample.valid), (over, true));
            },
        );
    }
}

#[test]
fn warm_up_moves_bias_and_flag_and_a_hot_start_does_not() {
    let cold = GyroParameters {
        ambient_celsius: 22.0,
        self_heating_kelvin: 20.0,
        thermal_time_constant_s: 2_100.0,
        bias_deg_per_h_per_kelvin: 3.0,
        reference_celsius: 42.0,
        warm_up_flag_kelvin: 1.0,
        ..Default::default()
    };
    let hot = GyroParameters { powered_before_s: 1e6, ..cold.clone() };
    let mut drift = gyro(cold, NAVIGATOR);
    let mut last = None;
    run(
        &mut drift,
        2_100.0,
        |_| Angle::ZERO,
        |sample| {
            assert!(sample.status.warming_up);
            last = Some(rate(sample));
        },
    );
    let expected_deg_per_h = -3.0 * 20.0 * (-1.0f64).exp();
    assert!((last.unwrap() * 3_600.0 - expected_deg_per_h).abs() < 1e-3, "{last:?}");
    assert!((drift.truth().bias.deg_per_h() - expected_deg_per_h).abs() < 1e-3);
    let mut steady = gyro(hot, NAVIGATOR);
    run(
        &mut steady,
        10.0,
        |_| Angle::ZERO,
        |sample| {
            assert!(!sample.status.warming_up);
            assert!(rate(sample).abs() < 1e-9);
        },
    );
}

#[test]
fn scale_depends_on_direction_rate_and_tilt() {
    let shown = |parameters, true_rate: f64| {
        let mut last = 0.0;
        run(
            &mut gyro(parameters, NAVIGATOR),
            1.0,
            |t| Angle::from_deg(true_rate * t),
            |sample| {
                last = rate(sample);
            },
        );
        last / true_rate
    };
    let asymmetric = GyroParameters { scale_asymmetry_ppm: 400.0, ..Default::default() };
    assert!((shown(asymmetric.clone(), 30.0) - 1.0002).abs() < 1e-9);
    assert!((shown(asymmetric, -30.0) - 0.9998).abs() < 1e-9);
    let cubic = GyroParameters { scale_ppm_at_30_deg_per_s: -1_000.0, ..Default::default() };
    assert!((shown(cubic.clone(), 30.0) - 0.999).abs() < 1e-9);
    assert!((shown(cubic, -15.0) - 0.99975).abs() < 1e-9);
    let tilted = GyroParameters { axis_tilt_deg: 1.0, ..Default::default() };
    assert!(((shown(tilted, 30.0) - 1.0) * 360.0 + 0.055).abs() < 1e-3);
}

#[test]
fn parameters_change_during_a_run() {
    let mut gyro =
        gyro(GyroParameters { thermal_time_constant_s: 10.0, ..Default::default() }, NAVIGATOR);
    run(&mut gyro, 3.505, |_| Angle::ZERO, |_| ());
    gyro.set_parameter("bias_deg_per_h", 3_600.0).unwrap();
    gyro.set_parameter("ambient_celsius", 30.0).unwrap();
    assert!(gyro.set_parameter("ambient", 30.0).is_err());
    let mut first = None;
    run(
        &mut gyro,
        13.5,
        |_| Angle::ZERO,
        |sample| {
            first.get_or_insert(rate(sample));
        },
    );
    assert!((first.unwrap() - 1.0).abs() < 1e-12);
    let expected = 30.0 - 10.0 * (-1.0f64).exp();
    assert!((gyro.truth().coil_temperature.celsius() - expected).abs() < 0.02);
}

/// The share of the rms that `bias_instability` computes, observed in the outputs of many gyros.
#[test]
fn a_bias_test_leaves_of_the_bias_instability_what_theory_says() {
    const UNITS: u32 = 1_500;
    let parameters = GyroParameters { bias_instability_rms_deg_per_s: 0.005, ..Default::default() };
    let square: f64 = (0..UNITS)
        .map(|seed| {
            let mut gyro = GyroEmulator::new(parameters.clone(), NAVIGATOR, seed.into(), "gyro");
            let mut mean = |until: f64| {
                let (mut sum, mut count) = (0.0, 0u32);
                run(
                    &mut gyro,
                    until,
                    |_| Angle::ZERO,
                    |sample| {
                        sum += rate(sample);
                        count += 1;
                    },
                );
                sum / f64::from(count)
            };
            let (test, lap) = (mean(20.0), mean(84.0));
            (lap - test).powi(2) / f64::from(UNITS)
        })
        .sum();
    let share = square.sqrt() / 0.005;
    // Standard error of an rms from 1500 draws: 1.8 %; 4 of them allowed.
    assert!((share / 0.5607 - 1.0).abs() < 0.073, "{share}");
}

/// Its seconds keep their grid, and its values stay the same.
#[test]
fn setting_parameters_leaves_the_bias_instability_alone() {
    let parameters = GyroParameters { bias_instability_rms_deg_per_s: 0.005, ..Default::default() };
    let rates = |interval_s: f64| {
        let mut gyro = gyro(parameters.clone(), NAVIGATOR);
        let (mut rates, mut until) = (Vec::new(), 0.0);
        while until < 30.0 {
            until += interval_s;
            run(&mut gyro, until, |_| Angle::ZERO, |sample| rates.push(rate(sample)));
            gyro.set_parameter("ambient_celsius", 20.0 + until).unwrap();
            let shown = rates.last().copied().unwrap_or_default();
            assert!((gyro.truth().bias.deg_per_s() - shown).abs() < 1e-12);
        }
        rates
    };
    let (often, never) = (rates(0.3), rates(30.0));
    assert_eq!(often.len(), never.len());
    assert!(often.iter().zip(&never).all(|(one, other)| (one - other).abs() < 1e-12));
    // Linear within a second, with another slope in the next.
    let second = |at: usize| never[at + 98] - never[at];
    assert!((2.0 * (never[149] - never[100]) - second(100)).abs() < 1e-12);
    assert!((second(200) - second(100)).abs() > 1e-6);
}

/// Allan variance of white noise N^2/t, of a Gauss-Markov process and of a rate random walk K^2 t/3 (IEEE Std
/// 952-1997, annex C), at averaging times where each one dominates.
#[test]
fn allan_deviations_are_those_of_theory() {
    let white = GyroParameters { angle_random_walk_deg_per_sqrt_h: 0.6, ..Default::default() };
    let walk = GyroParameters { rate_random_walk_deg_per_s_per_sqrt_s: 1e-3, ..Default::default() };
    let drift = GyroParameters {
        bias_drift_deg_per_s: 0.005,
        bias_drift_correlation_s: 10.0,
        ..Default::default()
    };
    // sigma^2 (2 r - 3 + 4 e^-r - e^-2r) / r^2, with the process's rms sigma and r = t/T.
    let markov = |t: f64| {
        let r = t / 10.0;
        let bracket = 2.0 * r - 3.0 + 4.0 * (-r).exp() - (-2.0 * r).exp();
        0.005 * (bracket / (r * r)).sqrt()
    };
    let cases: [(GyroParameters, &dyn Fn(f64) -> f64); 3] =
        [(white, &|t| 0.01 / t.sqrt()), (walk, &|t| 1e-3 * (t / 3.0).sqrt()), (drift, &markov)];
    for (parameters, theory) in cases {
        let mut rates = Vec::new();
        run(&mut gyro(parameters, NAVIGATOR), 20_000.0, |_| Angle::ZERO, |s| rates.push(rate(s)));
        for seconds in [1usize, 10, 20] {
            let means: Vec<f64> = rates
                .chunks_exact(seconds * 100)
                .map(|chunk| chunk.iter().sum::<f64>() / chunk.len() as f64)
                .collect();
            let square: f64 = means.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum();
            let deviation = (square / (2 * (means.len() - 1)) as f64).sqrt();
            // Relative standard error of an Allan deviation from n means: 1/sqrt(2 (n - 1)), more by
            // up to sqrt(3/2) where neighbours are correlated; 4 of them allowed.
            let allowed = 4.0 * (1.5 / (2.0 * (means.len() - 1) as f64)).sqrt();
            let ratio = deviation / theory(seconds as f64);
            assert!((ratio - 1.0).abs() < allowed, "{seconds} s: {ratio} +- {allowed}");
        }
    }
}

proptest! {
    #[test]
    fn the_mean_at_rest_is_the_bias(bias_deg_per_h in -100.0f64..100.0, seed: u64) {
        let parameters = GyroParameters {
            bias_deg_per_h,
            angle_random_walk_deg_per_sqrt_h: 0.083,
            ..Default::default()
        };
        let mut gyro = GyroEmulator::new(parameters, NAVIGATOR, seed, "gyro");
        let mut sum = 0.0;
        run(&mut gyro, 20.0, |_| Angle::ZERO, |sample| sum += rate(sample));
        // White noise leaves N/sqrt(20 s) in the mean; 6 of them allowed.
        let sigma = 0.083 / 60.0 / 20f64.sqrt();
        prop_assert!((sum / 2_000.0 - bias_deg_per_h / 3_600.0).abs() < 6.0 * sigma);
    }
}
