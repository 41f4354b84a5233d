use super::{BiasInstability, CorrelationTimes};
use crate::gyro::parameters::GyroParameters;
use crate::gyro::tests::variance_after_bias_test;
use proptest::prelude::*;
use std::f64::consts::{LN_2, PI};
use wire::units::Angle;

const RMS_DEG_PER_S: f64 = 0.005;

fn parameters() -> GyroParameters {
    GyroParameters { bias_instability_rms_deg_per_s: RMS_DEG_PER_S, ..Default::default() }
}

fn bank(seed: u64) -> BiasInstability {
    BiasInstability::new(&parameters(), 1.0, seed, "gyro")
}

/// The mean of `of` over the correlation times of the bank: processes of equal variance whose sum has unit variance.
fn over_the_bank(of: impl Fn(f64) -> f64) -> f64 {
    let times = CorrelationTimes::of(&parameters());
    times.seconds().map(of).sum::<f64>() / times.count as f64
}

/// Allan variance at `tau` of a first-order Gauss-Markov process of unit variance (IEEE Std
/// 952-1997, annex C).
fn allan_variance(tau: f64, correlation_s: f64) -> f64 {
    let r = tau / correlation_s;
    if r < 1e-3 {
        // The closed form loses its digits here: use its series, to the second power.
        return r * (2.0 / 3.0 - r / 2.0);
    }
    (2.0 * r - 3.0 + 4.0 * (-r).exp() - (-2.0 * r).exp()) / (r * r)
}

/// The same for correlation times evenly spread from 1 s to 10,000 s on a logarithmic scale.
fn allan_variance_of_evenly_spread(tau: f64) -> f64 {
    const PARTS: u32 = 2_000;
    let time = |part: u32| 10_000f64.powf((f64::from(part) + 0.5) / f64::from(PARTS));
    (0..PARTS).map(|part| allan_variance(tau, time(part))).sum::<f64>() / f64::from(PARTS)
}

/// 0.664 B for unit rms over four decades.
fn flat_allan_deviation() -> f64 {
    let b = (PI / 10_000f64.ln()).sqrt();
    b * (2.0 * LN_2 / PI).sqrt()
}

#[test]
fn twelve_processes_stand_for_four_decades() {
    let times: Vec<f64> = CorrelationTimes::of(&parameters()).seconds().collect();
    assert_eq!(times.len(), 12);
    assert!((times[0] - 10f64.powf(1.0 / 6.0)).abs() < 1e-9, "{times:?}");
    assert!((times[11] / 10f64.powf(4.0 - 1.0 / 6.0) - 1.0).abs() < 1e-9, "{times:?}");
}

/// The two errors stated at the head of the module, ripple and the ends of the band.
#[test]
fn the_allan_deviation_is_flat_within_the_band() {
    assert!((flat_allan_deviation() - 0.388).abs() < 5e-4);
    for tenth in 0..=40 {
        let tau = 10f64.powf(f64::from(tenth) / 10.0);
        let deviation = over_the_bank(|t| allan_variance(tau, t)).sqrt();
        let ripple = (deviation / allan_variance_of_evenly_spread(tau).sqrt() - 1.0).abs();
        let stated = if (3.0..=3_000.0).contains(&tau) { 0.0021 } else { 0.004 };
        assert!(ripple < stated, "{tau} s: {ripple}");
        let of_flat = deviation / flat_allan_deviation();
        assert!(of_flat < 1.0, "{tau} s: {of_flat}");
        assert_eq!(of_flat > 0.95, (14.0..=2_100.0).contains(&tau), "{tau} s: {of_flat}");
    }
}

/// After a 20 s bias test, 0.56 of the rms remains in the mean over the following 64 s of travel: of the data sheet's
/// 0.005 deg/s this is 0.0028 deg/s, 0.18 deg in the lap. From the autocovariance of the processes; the linear course
/// within a second changes less than the last digit.
#[test]
fn a_bias_test_leaves_more_than_half_of_the_rms() {
    let left = over_the_bank(|t| variance_after_bias_test(20.0, 64.0, t)).sqrt();
    println!("share of the rms left in 64 s after a 20 s bias test: {left:.4}");
    assert!((left - 0.5607).abs() < 5e-5, "{left}");
}

#[test]
fn straight_lines_within_a_second_cost_what_is_stated() {
    // Mean square of a straight line between two values of correlation c: 2/3 + c/3.
    let lost = over_the_bank(|t| (1.0 - (-1.0 / t).exp()) / 3.0);
    assert!((lost - 0.028).abs() < 5e-4, "{lost}");
    assert!((1.0 - (1.0 - lost).sqrt() - 0.014).abs() < 5e-4);
}

/// Variance at power-up and after 100 s, and half a second later, over many power-ups.
#[test]
fn it_is_stationary_from_power_up_on() {
    const UNITS: u32 = 4_000;
    let rms = Angle::from_deg(RMS_DEG_PER_S).rad();
    let mut squares = [0.0; 3];
    for seed in 0..UNITS {
        let mut bank = bank(seed.into());
        let first = bank.at(1.0);
        (0..100).for_each(|_| bank.advance());
        let values = [first, bank.at(0.0), bank.at(0.5)];
        for (square, value) in squares.iter_mut().zip(values) {
            *square += (value / rms).powi(2) / f64::from(UNITS);
        }
    }
    // Halfway between two values of correlation c: 1/2 + c/2.
    let halfway = 0.5 + over_the_bank(|t| (-1.0 / t).exp()) / 2.0;
    // Standard error of a variance from 4000 draws: 2.2 %; 4 of them allowed.
    for (square, expected) in squares.into_iter().zip([1.0, 1.0, halfway]) {
        assert!((square / expected - 1.0).abs() < 0.09, "{square} {expected}");
    }
}

/// The simulated seconds, compared with the flat 0.664 B and the exact value for this bank.
#[test]
fn the_simulated_allan_deviation_is_that_of_theory() {
    const SECONDS: usize = 2_000_000;
    let rms = Angle::from_deg(RMS_DEG_PER_S).rad();
    let mut bank = bank(1);
    let values: Vec<f64> = (0..SECONDS)
        .map(|_| {
            bank.advance();
            // The mean over the second: it is linear.
            bank.at(0.5) / rms
        })
        .collect();
    for tau in [30usize, 100, 300, 1_000] {
        let means: Vec<f64> = values
            .chunks_exact(tau)
            .map(|chunk| chunk.iter().sum::<f64>() / chunk.len() as f64)
            .collect();
        let square: f64 = means.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum();
        let deviation = (square / (2 * (means.len() - 1)) as f64).sqrt();
        // Relative standard error from n means: 1/sqrt(2 (n - 1)), more by up to sqrt(3/2) where
        // neighbours are correlated; 4 of them allowed.
        let allowed = 4.0 * (1.5 / (2.0 * (means.len() - 1) as f64)).sqrt();
        let exact = over_the_bank(|t| allan_variance(tau as f64, t)).sqrt();
        assert!((deviation / exact - 1.0).abs() < allowed, "{tau} s: {deviation} {exact}");
        assert!((deviation / flat_allan_deviation() - 1.0).abs() < 0.03 + allowed, "{tau} s");
    }
}

proptest! {
    /// For any ends of the band, in either order.
    #[test]
    fn any_band_has_unit_variance_within_its_ends(
        log_shortest in -300.0f64..300.0, log_longest in -300.0f64..300.0, seed: u64,
    ) {
        let ends = [log_shortest, log_longest].map(|log| 10f64.powf(log));
        let parameters = GyroParameters {
            bias_instability_shortest_s: ends[0],
            bias_instability_longest_s: ends[1],
            ..parameters()
        };
        for time_s in CorrelationTimes::of(&parameters).seconds() {
            prop_assert!(time_s > ends[0].min(ends[1]) * 0.999);
            prop_assert!(time_s < ends[0].max(ends[1]) * 1.001);
        }
        let mut bank = BiasInstability::new(&parameters, 1.0, seed, "gyro");
        for process in &bank.processes[..bank.count] {
            prop_assert!((process.decay.powi(2) + process.drive.powi(2) - 1.0).abs() < 1e-12);
        }
        bank.advance();
        // Eight standard deviations.
        prop_assert!(bank.at(1.0).abs() < 8.0 * Angle::from_deg(RMS_DEG_PER_S).rad());
    }
}
