//! The static bias test: the mean of the readings at rest, and a check that the gyro really was at rest.

use crate::config::GyroConfig;
use crate::mission::BiasTestResult;
use wire::units::{AngularRate, Temperature};

/// Running mean and spread of readings (Welford's recurrence: exact for long runs).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct RunningMean {
    count: u32,
    mean: f64,
    sum_of_squares: f64,
}

impl RunningMean {
    pub(crate) fn add(&mut self, value: f64) {
        self.count = self.count.saturating_add(1);
        let difference = value - self.mean;
        self.mean += difference / f64::from(self.count);
        self.sum_of_squares += difference * (value - self.mean);
    }

    /// Merges all values of `other`.
    pub(crate) fn join(&mut self, other: &Self) {
        let (before, more) = (f64::from(self.count), f64::from(other.count));
        if other.count == 0 {
            return;
        }
        let difference = other.mean - self.mean;
        let all = before + more;
        self.count = self.count.saturating_add(other.count);
        self.mean += difference * more / all;
        self.sum_of_squares += other.sum_of_squares + difference * difference * before * more / all;
    }

    pub(crate) const fn count(&self) -> u32 {
        self.count
    }

    pub(crate) const fn mean(&self) -> f64 {
        self.mean
    }

    /// Sample standard deviation; zero for fewer than two values.
    pub(crate) fn spread(&self) -> f64 {
        if self.count < 2 {
            return 0.0;
        }
        libm::sqrt(self.sum_of_squares / f64::from(self.count - 1))
    }
}

/// Readings of one test.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct BiasAverage {
    all: RunningMean,
    first_half: RunningMean,
    second_half: RunningMean,
    celsius: RunningMean,
}

impl BiasAverage {
    /// Takes one raw reading.
    pub(crate) fn add(
        &mut self,
        rate: AngularRate,
        temperature: Option<Temperature>,
        in_first_half: bool,
    ) {
        self.all.add(rate.rad_per_s());
        let half = if in_first_half { &mut self.first_half } else { &mut self.second_half };
        half.add(rate.rad_per_s());
        if let Some(temperature) = temperature {
            self.celsius.add(temperature.celsius());
        }
    }

    /// True if the readings are those of a gyro at rest: low spread, no drift between the halves, a credible mean, and
    /// enough readings in each half.
    pub(crate) fn was_at_rest(&self, config: &GyroConfig) -> bool {
        let drift = (self.second_half.mean() - self.first_half.mean()).abs();
        self.first_half.count() > 0
            && self.second_half.count() > 0
            && self.all.spread() <= config.rest_spread_max.rad_per_s()
            && drift <= config.rest_drift_max.rad_per_s()
            && self.all.mean().abs() <= config.bias_max.rad_per_s()
    }

    /// Mean temperature of the readings.
    pub(crate) fn temperature(&self) -> Option<Temperature> {
        (self.celsius.count() > 0).then(|| Temperature::from_celsius(self.celsius.mean()))
    }

    /// The reported result; `table` is the bias by temperature, for comparison.
    pub(crate) fn result(&self, table: Option<AngularRate>) -> BiasTestResult {
        BiasTestResult {
            mean: AngularRate::from_rad_per_s(self.all.mean()),
            spread: AngularRate::from_rad_per_s(self.all.spread()),
            samples: self.all.count(),
            temperature: self.temperature(),
            table,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{AngularRate, BiasAverage, GyroConfig, RunningMean};
    use proptest::prelude::*;

    const SAMPLES: usize = 2_000;

    fn average(reading_deg_per_s: fn(usize) -> f64) -> BiasAverage {
        let mut average = BiasAverage::default();
        for index in 0..SAMPLES {
            let rate = AngularRate::from_deg_per_s(reading_deg_per_s(index));
            average.add(rate, None, index < SAMPLES / 2);
        }
        average
    }

    fn wobble(index: usize) -> f64 {
        if index.is_multiple_of(2) { 0.01 } else { -0.01 }
    }

    #[test]
    fn rest_is_told_from_motion() {
        let config = GyroConfig::default();
        type Case = (&'static str, fn(usize) -> f64, bool);
        let cases: [Case; 5] = [
            ("rest", |i| 0.02 + wobble(i), true),
            ("slow turn", |i| 1.0 + wobble(i), false),
            ("shaken", |i| 20.0 * wobble(i), false),
            ("starts to move", |i| if i < SAMPLES / 2 { 0.0 } else { 0.04 }, false),
            ("one shock", |i| if i == 700 { 30.0 } else { 0.0 }, false),
        ];
        for (name, reading, expected) in cases {
            assert_eq!(average(reading).was_at_rest(&config), expected, "{name}");
        }
        assert!(!BiasAverage::default().was_at_rest(&config), "no readings are no rest");
    }

    proptest! {
        #[test]
        fn the_recurrence_is_the_textbook_formula(values in prop::collection::vec(-10.0f64..10.0, 2..200)) {
            let mut running = RunningMean::default();
            values.iter().for_each(|&value| running.add(value));
            let (mut joined, mut rest) = (RunningMean::default(), RunningMean::default());
            let (first, second) = values.split_at(values.len() / 3);
            first.iter().for_each(|&value| joined.add(value));
            second.iter().for_each(|&value| rest.add(value));
            joined.join(&rest);
            let n = values.len() as f64;
            let mean = values.iter().sum::<f64>() / n;
            let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
            prop_assert!((running.mean() - mean).abs() < 1e-12 * n);
            prop_assert!((running.spread() - variance.sqrt()).abs() < 1e-9);
            prop_assert!((joined.mean() - mean).abs() < 1e-12 * n);
            prop_assert!((joined.spread() - variance.sqrt()).abs() < 1e-9);
        }
    }
}
