//! The random part of a gyro's error: white noise, bias instability, exponentially correlated drift,
//! rate random walk, turn-on bias.

use super::bias_instability::BiasInstability;
use super::parameters::{GyroParameters, remainder};
use crate::random::RandomStream;
use libm::{round, sqrt};
use wire::units::{Angle, AngularRate};

const SECONDS_PER_HOUR: f64 = 3_600.0;

/// Noise of the rate in rad/s. Every term is discretised exactly: its variance and correlation at the steps are those
/// of the continuous process. White noise, drift and walk are stepped from output to output; the slow bias
/// (instability and turn-on) from second to second.
///
/// Each term has its own random stream and draws no more numbers while it is off.
#[derive(Debug, Clone)]
pub(super) struct RateNoise {
    white: RandomStream,
    white_sigma: f64,
    /// True if one of the next two is on.
    wanders: bool,
    /// First-order Gauss-Markov, with unit variance.
    drift: Term,
    drift_sigma: f64,
    /// e^(-h/correlation time), and the drive that keeps the variance at one.
    drift_decay: f64,
    drift_drive: f64,
    /// Outputs from draw to draw, and until the next one.
    drift_every: u32,
    drift_due: u32,
    walk: Term,
    walk_sigma: f64,
    instability: BiasInstability,
    turn_on_draw: f64,
    turn_on: f64,
}

#[derive(Debug, Clone)]
struct Term {
    stream: RandomStream,
    state: f64,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Steps {
    /// From output to output.
    pub(super) output_s: f64,
    /// From one value of the slow bias to the next.
    pub(super) slow_s: f64,
}

impl RateNoise {
    /// Noise of `device` in a run with `seed`.
    pub(super) fn new(parameters: &GyroParameters, steps: Steps, seed: u64, device: &str) -> Self {
        let stream = |purpose| RandomStream::new(seed, device, purpose);
        let term = |purpose| Term { stream: stream(purpose), state: 0.0 };
        let mut noise = Self {
            white: stream("gyro white noise"),
            white_sigma: 0.0,
            wanders: false,
            drift: term("gyro bias drift"),
            drift_sigma: 0.0,
            drift_decay: 0.0,
            drift_drive: 0.0,
            drift_every: 1,
            drift_due: 0,
            walk: term("gyro rate random walk"),
            walk_sigma: 0.0,
            instability: BiasInstability::new(parameters, steps.slow_s, seed, device),
            turn_on_draw: stream("gyro turn-on bias").standard_normal(),
            turn_on: 0.0,
        };
        // The drift starts in its steady distribution.
        noise.drift.state = noise.drift.stream.standard_normal();
        noise.configure(parameters, steps);
        noise
    }

    /// Applies changed parameters or other steps; the current state stays.
    pub(super) fn configure(&mut self, parameters: &GyroParameters, steps: Steps) {
        // N deg/sqrt(h) is a density of N/60 deg/s/sqrt(Hz); the mean of a step has variance N^2/h.
        self.white_sigma = Angle::from_deg(parameters.angle_random_walk_deg_per_sqrt_h).rad()
            / sqrt(SECONDS_PER_HOUR * steps.output_s);
        self.drift_sigma = Angle::from_deg(parameters.bias_drift_deg_per_s).rad();
        let held = round(parameters.bias_drift_held_s / steps.output_s);
        self.drift_decay = match held > 0.0 {
            true => 0.0,
            false => remainder(steps.output_s, parameters.bias_drift_correlation_s),
        };
        // The conversion saturates.
        self.drift_every = (held as u32).max(1);
        self.drift_drive = sqrt(1.0 - self.drift_decay * self.drift_decay);
        self.walk_sigma = Angle::from_deg(parameters.rate_random_walk_deg_per_s_per_sqrt_s).rad()
            * sqrt(steps.output_s);
        // A walk that is switched off keeps its last value.
        self.wanders = self.drift_sigma > 0.0 || self.walk_sigma > 0.0 || self.walk.state != 0.0;
        self.instability.configure(parameters, steps.slow_s);
        self.turn_on = AngularRate::from_deg_per_h(parameters.turn_on_bias_deg_per_h).rad_per_s()
            * self.turn_on_draw;
    }

    pub(super) fn advance_slow(&mut self) {
        self.instability.advance();
    }

    /// The slow bias after `share` of its step; it is linear within a step.
    pub(super) fn slow_bias(&self, share: f64) -> f64 {
        self.turn_on + self.instability.at(share)
    }

    /// Drift and walk, as of the last output.
    pub(super) fn wander(&self) -> f64 {
        self.drift_sigma * self.drift.state + self.walk.state
    }

    /// The noise of the next output, without the slow bias.
    #[inline]
    pub(super) fn next(&mut self) -> f64 {
        let white = if self.white_sigma > 0.0 {
            self.white_sigma * self.white.standard_normal()
        } else {
            0.0
        };
        if self.wanders { white + self.next_wander() } else { white }
    }

    fn next_wander(&mut self) -> f64 {
        if self.drift_sigma > 0.0 && self.drift_due == 0 {
            self.drift.state = self.drift_decay * self.drift.state
                + self.drift_drive * self.drift.stream.standard_normal();
            self.drift_due = self.drift_every;
        }
        self.drift_due = self.drift_due.saturating_sub(1);
        if self.walk_sigma > 0.0 {
            self.walk.state += self.walk_sigma * self.walk.stream.standard_normal();
        }
        self.wander()
    }
}

#[cfg(test)]
mod tests {
    use super::{RateNoise, Steps};
    use crate::gyro::parameters::{GyroParameters, WORST_CASE_CORRELATION_S};
    use crate::gyro::tests::variance_after_bias_test;
    use wire::units::Angle;

    const STEPS: Steps = Steps { output_s: 0.01, slow_s: 1.0 };

    #[test]
    fn the_assumed_correlation_time_is_the_least_favourable_one() {
        // The paper's 20 s bias test and the 64 s of travel of its lap, on a grid of whole seconds.
        let variance = |seconds: u32| variance_after_bias_test(20.0, 64.0, f64::from(seconds));
        let worst = (1..=1_000).max_by(|&a, &b| variance(a).total_cmp(&variance(b))).unwrap();
        assert_eq!(f64::from(worst), WORST_CASE_CORRELATION_S);
        // A bias test then leaves 0.89 of the drift's rms: 0.0045 of the data sheet's 0.005 deg/s,
        // 0.29 deg in 64 s.
        assert!((variance(worst).sqrt() - 0.8913).abs() < 1e-4);
    }

    /// The noise in a plan: means over a bias test and the lap that follows.
    #[test]
    fn the_simulated_drift_has_that_variance() {
        const PAIRS: u32 = 2_000;
        let parameters = GyroParameters { bias_drift_deg_per_s: 0.005, ..Default::default() };
        let mut noise = RateNoise::new(&parameters, Steps { output_s: 0.1, ..STEPS }, 11, "gyro");
        let mut mean = |seconds: u32| {
            (0..seconds * 10).map(|_| noise.next()).sum::<f64>() / f64::from(seconds * 10)
        };
        let square: f64 = (0..PAIRS)
            .map(|_| {
                let test = mean(20);
                let lap = mean(64);
                mean(100);
                (lap - test).powi(2) / f64::from(PAIRS)
            })
            .sum();
        let expected = variance_after_bias_test(20.0, 64.0, WORST_CASE_CORRELATION_S)
            * Angle::from_deg(0.005).rad().powi(2);
        // Standard error of a variance from 2000 independent pairs: 3.2 %; 4 of them allowed.
        assert!((square / expected - 1.0).abs() < 0.13, "{}", square / expected);
    }

    #[test]
    fn a_drift_that_is_held_is_constant_and_then_drawn_anew() {
        let parameters = GyroParameters {
            bias_drift_deg_per_s: 0.005,
            bias_drift_held_s: 84.0,
            ..Default::default()
        };
        let mut noise = RateNoise::new(&parameters, Steps { output_s: 0.1, ..STEPS }, 11, "gyro");
        let draws: Vec<f64> = (0..2_000)
            .map(|_| {
                let first = noise.next();
                assert!((1..840).all(|_| noise.next() == first));
                first / Angle::from_deg(0.005).rad()
            })
            .collect();
        let square = draws.iter().map(|draw| draw * draw).sum::<f64>() / 2_000.0;
        let product: f64 = draws.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / 1_999.0;
        // Standard errors: 0.032 and 0.022; 4 of them allowed.
        assert!((square - 1.0).abs() < 0.13 && product.abs() < 0.09, "{square} {product}");
    }

    #[test]
    fn terms_that_are_off_are_silent_and_the_others_keep_their_numbers() {
        let mut off = RateNoise::new(&GyroParameters::default(), STEPS, 1, "gyro");
        assert!((0..100).all(|_| off.next() == 0.0));
        let white = GyroParameters { angle_random_walk_deg_per_sqrt_h: 0.1, ..Default::default() };
        let both = GyroParameters { rate_random_walk_deg_per_s_per_sqrt_s: 1e-3, ..white.clone() };
        let mut alone = RateNoise::new(&white, STEPS, 1, "gyro");
        let mut with_walk = RateNoise::new(&both, STEPS, 1, "gyro");
        for _ in 0..100 {
            let (white, sum) = (alone.next(), with_walk.next());
            assert!((sum - with_walk.wander() - white).abs() < 1e-15);
        }
    }

    #[test]
    fn turn_on_bias_has_its_rms_over_many_power_ups() {
        const UNITS: u32 = 2_000;
        let parameters = GyroParameters { turn_on_bias_deg_per_h: 10.0, ..Default::default() };
        let square: f64 = (0..UNITS)
            .map(|seed| {
                RateNoise::new(&parameters, STEPS, seed.into(), "gyro").slow_bias(0.0).powi(2)
            })
            .sum();
        let rms_deg_per_h = (square / f64::from(UNITS)).sqrt().to_degrees() * 3_600.0;
        // Standard error of an rms from 2000 draws: 1.6 %; 4 of them allowed.
        assert!((rms_deg_per_h / 10.0 - 1.0).abs() < 0.064, "{rms_deg_per_h}");
    }
}
