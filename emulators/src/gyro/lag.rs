//! The bandwidth of a gyro: a first-order lag of the rate.

use libm::exp;
use std::f64::consts::TAU;

/// A first-order lag, stepped from output to output.
///
/// The rate is taken as constant u within a step h. Then the lagged rate goes from y to u + (y - u) e^(-h/T) and its
/// mean is u + (y - u) (T/h) (1 - e^(-h/T)), both exact; T is 1 / (2 pi bandwidth). No angle is lost: what one step
/// holds back appears in the following ones.
#[derive(Debug, Clone, Copy)]
pub(super) struct RateLag {
    state: f64,
    /// e^(-h/T).
    decay: f64,
    /// (T/h) (1 - e^(-h/T)): the share of a difference that the mean of a step still shows.
    held: f64,
}

impl RateLag {
    pub(super) fn new(bandwidth_hz: f64, step_s: f64) -> Self {
        let time_constant_s = 1.0 / (TAU * bandwidth_hz);
        let steps = step_s / time_constant_s;
        // An infinite bandwidth leaves no lag; one near zero (steps underflow) blocks everything.
        let (decay, held) = if steps.is_infinite() {
            (0.0, 0.0)
        } else if steps < f64::EPSILON {
            (1.0, 1.0)
        } else {
            let decay = exp(-steps);
            (decay, (1.0 - decay) / steps)
        };
        Self { state: 0.0, decay, held }
    }

    /// The lag for another step, with its state kept.
    pub(super) fn with(self, bandwidth_hz: f64, step_s: f64) -> Self {
        Self { state: self.state, ..Self::new(bandwidth_hz, step_s) }
    }

    /// The mean of the lagged rate over a step in which the true rate was `rate`.
    #[inline]
    pub(super) fn mean(&mut self, rate: f64) -> f64 {
        let difference = self.state - rate;
        self.state = rate + difference * self.decay;
        rate + difference * self.held
    }
}

#[cfg(test)]
mod tests {
    use super::RateLag;
    use proptest::prelude::*;
    use std::f64::consts::TAU;

    #[test]
    fn an_infinite_bandwidth_changes_nothing() {
        let mut lag = RateLag::new(f64::INFINITY, 0.01);
        assert_eq!([1.0, -2.0, 3.0].map(|rate| lag.mean(rate)), [1.0, -2.0, 3.0]);
    }

    #[test]
    fn a_step_rises_with_the_time_constant() {
        // 1 ms steps of a 100 Hz lag: 1 - e^(-t/T) at the end of each step.
        let mut lag = RateLag::new(100.0, 0.001);
        for step in 1..=20 {
            lag.mean(1.0);
            let expected = 1.0 - (-f64::from(step) * 0.001 * TAU * 100.0).exp();
            assert!((lag.state - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn a_sine_at_the_bandwidth_falls_by_three_decibel() {
        // Steps far shorter than the period, so that "constant within a step" is accurate.
        const STEP_S: f64 = 1e-6;
        let mut lag = RateLag::new(100.0, STEP_S);
        let peak = (0..100_000)
            .map(|n| lag.mean((TAU * 100.0 * f64::from(n) * STEP_S).sin()))
            .skip(50_000)
            .fold(0.0, f64::max);
        assert!((peak - 0.5f64.sqrt()).abs() < 1e-3, "{peak}");
    }

    proptest! {
        #[test]
        fn no_angle_is_lost(
            rates in prop::collection::vec(-2.0f64..2.0, 1..50),
            bandwidth_hz in 5.0f64..1e4,
        ) {
            let mut lag = RateLag::new(bandwidth_hz, 0.01);
            let turned: f64 = rates.iter().sum();
            let shown: f64 = rates.iter().map(|&rate| lag.mean(rate)).sum();
            let rest: f64 = (0..2_000).map(|_| lag.mean(0.0)).sum();
            prop_assert!((shown + rest - turned).abs() < 1e-9);
        }
    }
}
