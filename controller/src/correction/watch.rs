//! Keeps the drivers of the terms up to date and computes the sums of the terms.

use super::history::History;
use super::slope::Slope;
use super::{Acts, BIAS_SUM_MAX, Corrections, Driver, SCALE_SUM_MAX, TERMS_MAX, Term};
use wire::time::{Span, Timestamp};
use wire::units::{Angle, AngularRate, Temperature};

/// After a longer silence the gyro counts as switched on again. Assumption: unplugging a line and plugging it in again
/// takes less; switching a gyro off and on takes more.
pub const POWER_OFF_MIN: Span = Span::from_secs(5);
/// Slower rates have no direction. Assumption: seven times the 0.014 deg/s of noise that 5 deg/h/sqrt(Hz) gives at 100
/// Hz, and a third of the controller's slowest turn.
pub const REST_RATE: AngularRate = AngularRate::from_deg_per_s(0.1);

/// Number of iterations: the terms depend on the corrected rate, which depends on the terms. Each iteration reduces
/// the error to the size of the terms, a percent or less.
const RATE_ITERATIONS: usize = 2;

/// State of the drivers with a memory: of a term and of its second driver.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Memory {
    first: Option<f64>,
    second: Option<f64>,
}

/// Sums of the terms for one reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sum {
    /// The sensor's additive error, rad/s; at most [`BIAS_SUM_MAX`].
    pub(crate) bias: f64,
    /// The sensor's scale; differs from one by at most [`SCALE_SUM_MAX`].
    pub(crate) scale: f64,
}

/// Keeps the drivers of the terms.
#[derive(Debug, Clone, Default)]
pub(crate) struct Watch {
    temperature: Option<f64>,
    told: Option<Timestamp>,
    slope: Slope,
    history: History,
    first_heard: Option<Timestamp>,
    switched_on: Option<Timestamp>,
    heard: Option<Timestamp>,
    memories: [Memory; TERMS_MAX],
    sees_rate: bool,
}

/// Values of the drivers at the moment of one reading.
#[derive(Clone, Copy)]
struct Moment {
    rate: f64,
    heading: f64,
    tested_bias: f64,
    time_s: f64,
    uptime_s: f64,
}

impl Watch {
    /// Installs other terms: their memories are computed from the temperatures so far.
    pub(crate) fn begin(&mut self, terms: &Corrections) {
        self.memories = [Memory::default(); TERMS_MAX];
        self.sees_rate = terms.iter().any(Term::sees_rate);
        for (celsius, passed_s) in self.history.steps() {
            remember(&mut self.memories, terms, celsius, passed_s);
        }
        if let (Some(celsius), Some(told)) = (self.temperature, self.told) {
            let passed_s = self.history.since_last(told);
            remember(&mut self.memories, terms, celsius, passed_s);
        }
    }

    /// A sample arrived at `now`.
    pub(crate) fn hear(&mut self, now: Timestamp) {
        if self.heard.is_none_or(|heard| now - heard > POWER_OFF_MIN) {
            self.switched_on = Some(now);
        }
        self.first_heard.get_or_insert(now);
        self.heard = Some(now);
    }

    /// The gyro reported its temperature, about once a second.
    pub(crate) fn tell(&mut self, now: Timestamp, temperature: Temperature, terms: &Corrections) {
        let celsius = temperature.celsius();
        let passed_s = self.told.map_or(0.0, |told| (now - told).as_secs_f64());
        self.told = Some(now);
        self.temperature = Some(celsius);
        self.slope.add(now, celsius);
        self.history.add(now, celsius);
        remember(&mut self.memories, terms, celsius, passed_s);
    }

    /// Sums of `terms` at `now`. `less_bias` is the raw rate minus the tested bias in rad/s; `tested_bias` is the
    /// value of the driver of that name; `gain` gives the factors of Eq. 4 for a direction.
    pub(crate) fn sum(
        &self,
        now: Timestamp,
        terms: &Corrections,
        less_bias: f64,
        heading: Angle,
        tested_bias: AngularRate,
        gain: impl Fn(f64) -> f64,
    ) -> Sum {
        let since = |at: Option<Timestamp>| at.map_or(0.0, |at| (now - at).as_secs_f64());
        let mut moment = Moment {
            rate: less_bias * gain(less_bias),
            heading: heading.rad(),
            tested_bias: tested_bias.rad_per_s(),
            time_s: since(self.switched_on),
            uptime_s: since(self.first_heard),
        };
        let mut sum = self.at(terms, &moment);
        if self.sees_rate {
            for _ in 0..RATE_ITERATIONS {
                let rate = less_bias - sum.bias;
                moment.rate = rate * gain(rate) / sum.scale;
                sum = self.at(terms, &moment);
            }
        }
        sum
    }

    fn at(&self, terms: &Corrections, moment: &Moment) -> Sum {
        let (mut bias, mut scale) = (0.0, 0.0);
        for (term, memory) in terms.iter().zip(&self.memories) {
            let second = term.form.second();
            let (Some(x), Some(y)) = (
                self.driver(term.driver, memory.first, moment),
                self.driver(second, memory.second, moment),
            ) else {
                continue;
            };
            match term.acts {
                Acts::Bias => bias += term.value(x, y),
                Acts::Scale => scale += term.value(x, y),
            }
        }
        Sum {
            bias: bounded(bias, BIAS_SUM_MAX.rad_per_s()),
            scale: 1.0 + bounded(scale, SCALE_SUM_MAX),
        }
    }

    fn driver(&self, driver: Driver, memory: Option<f64>, moment: &Moment) -> Option<f64> {
        match driver {
            Driver::None => Some(0.0),
            Driver::Temperature => self.temperature,
            Driver::TemperatureRate => self.slope.per_s(),
            Driver::TemperatureLag { .. } => memory,
            Driver::TemperatureBranch { .. } => Some(memory? - self.temperature?),
            Driver::Rate => Some(moment.rate),
            Driver::AbsRate => Some(moment.rate.abs()),
            Driver::Direction if moment.rate.abs() < REST_RATE.rad_per_s() => Some(0.0),
            Driver::Direction => Some(1f64.copysign(moment.rate)),
            Driver::Heading => Some(moment.heading),
            Driver::TestedBias => Some(moment.tested_bias),
            Driver::Time => Some(moment.time_s),
            Driver::Uptime => Some(moment.uptime_s),
        }
    }
}

/// The temperature has been `celsius` for `passed_s`.
fn remember(memories: &mut [Memory; TERMS_MAX], terms: &Corrections, celsius: f64, passed_s: f64) {
    for (term, memory) in terms.iter().zip(memories) {
        memory.first = follow(term.driver, memory.first, celsius, passed_s);
        memory.second = follow(term.form.second(), memory.second, celsius, passed_s);
    }
}

/// The new state of a driver with a memory after `passed_s` at the temperature `celsius`.
fn follow(driver: Driver, memory: Option<f64>, celsius: f64, passed_s: f64) -> Option<f64> {
    match driver {
        Driver::TemperatureLag { time_constant_s } => {
            let last = memory.unwrap_or(celsius);
            Some(celsius + (last - celsius) * libm::exp(-passed_s / time_constant_s))
        }
        Driver::TemperatureBranch { half_width_kelvin } => {
            let last = memory.unwrap_or(celsius);
            Some(last.clamp(celsius - half_width_kelvin, celsius + half_width_kelvin))
        }
        _ => None,
    }
}

/// Limits `sum` to `limit` on either side of zero; zero where the sum overflowed.
fn bounded(sum: f64, limit: f64) -> f64 {
    if sum.is_nan() { 0.0 } else { sum.clamp(-limit, limit) }
}
