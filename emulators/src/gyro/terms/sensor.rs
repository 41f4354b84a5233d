//! A rate sensor that errs as terms say: for devices that are described, and have no physics of their own.

use super::{Driver, Memory, Moment, Term};
use crate::device_file::Learned;
use crate::gyro::parameters::remainder;
use std::f64::consts::TAU;

/// What is true at one instant, as a sensor's surroundings have it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Seen {
    /// Rate, rad/s.
    pub rate: f64,
    /// Heading, rad.
    pub heading: f64,
    /// Temperature, degC.
    pub celsius: f64,
    /// Time since power-up, s.
    pub time_s: f64,
}

/// How a rate sensor errs.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorErrors {
    /// Error terms.
    pub terms: Vec<Term>,
    /// Time constant of the first-order lag of the rate, s; 0 for none.
    pub time_constant_s: f64,
    /// Scaled rates below it are taken as none, rad/s.
    pub dead_zone: f64,
    /// It shows no more than this, rad/s.
    pub range: f64,
}

impl Default for SensorErrors {
    /// None.
    fn default() -> Self {
        Self { terms: Vec::new(), time_constant_s: 0.0, dead_zone: 0.0, range: f64::INFINITY }
    }
}

impl SensorErrors {
    /// What was learned of a gyro.
    ///
    /// # Errors
    ///
    /// Says what a sensor without a clock of its own has no place for: a latency.
    pub fn of(learned: Learned) -> Result<Self, String> {
        let mut errors = Self { terms: learned.terms, ..Self::default() };
        for (name, value) in learned.parameters {
            match name.as_str() {
                "bandwidth_hz" => errors.time_constant_s = 1.0 / (TAU * value),
                "dead_zone_deg_per_s" => errors.dead_zone = value.to_radians(),
                "range_deg_per_s" => errors.range = value.to_radians(),
                _ => return Err(format!("a signal has no place for its `{name}` of {value}")),
            }
        }
        Ok(errors)
    }

    /// Does a term see the temperature?
    pub fn see_temperature(&self) -> bool {
        self.see(|driver| {
            matches!(
                driver,
                Driver::Temperature
                    | Driver::TemperatureRate
                    | Driver::TemperatureLag { .. }
                    | Driver::TemperatureBranch { .. }
            )
        })
    }

    /// Does a term see the heading?
    pub fn see_heading(&self) -> bool {
        self.see(|driver| driver == Driver::Heading)
    }

    fn see(&self, wanted: impl Fn(Driver) -> bool) -> bool {
        self.terms.iter().any(|term| wanted(term.driver) || wanted(term.form.second()))
    }
}

/// A rate sensor at work. What is true is taken as constant from one reading to the next.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    memory: Memory,
    before: Seen,
    /// The rate as it comes through the lag.
    lagged: f64,
}

impl Sensor {
    /// At power-up, where this has been so for long.
    pub fn new(errors: &SensorErrors, seen: &Seen) -> Self {
        let memory = Memory::new(&errors.terms, seen.celsius);
        Self { memory, before: *seen, lagged: seen.rate }
    }

    /// The rate that it reads now, rad/s.
    pub fn read(&mut self, errors: &SensorErrors, seen: &Seen) -> f64 {
        let passed_s = seen.time_s - self.before.time_s;
        let kelvin_per_s =
            if passed_s > 0.0 { (seen.celsius - self.before.celsius) / passed_s } else { 0.0 };
        self.memory.advance(&errors.terms, seen.celsius, passed_s);
        self.lagged =
            seen.rate + (self.lagged - seen.rate) * remainder(passed_s, errors.time_constant_s);
        self.before = *seen;
        let moment = Moment {
            celsius: seen.celsius,
            kelvin_per_s,
            time_s: seen.time_s,
            rate: self.lagged,
            heading: seen.heading,
        };
        let [slow, fast] = [false, true].map(|fast| self.memory.sums(&errors.terms, &moment, fast));
        let scaled = self.lagged * (1.0 + slow.scale + fast.scale);
        let scaled = if scaled.abs() < errors.dead_zone { 0.0 } else { scaled };
        (scaled + slow.bias + fast.bias).clamp(-errors.range, errors.range)
    }
}

#[cfg(test)]
mod tests {
    use super::{Seen, Sensor, SensorErrors};
    use crate::device_file::Learned;
    use crate::gyro::terms::{Acts, Driver, Form, Term};
    use proptest::prelude::*;

    fn seen(rate: f64, celsius: f64, time_s: f64) -> Seen {
        Seen { rate, celsius, time_s, ..Seen::default() }
    }

    #[test]
    fn bias_and_scale_come_on_top_of_the_truth() {
        let term = |acts, slope| Term {
            acts,
            driver: Driver::Temperature,
            form: Form::Linear { slope, origin: 20.0 },
        };
        let terms = vec![term(Acts::Bias, 1e-3), term(Acts::Scale, 1e-2)];
        let errors = SensorErrors { terms, ..SensorErrors::default() };
        assert!(errors.see_temperature() && !errors.see_heading());
        let mut sensor = Sensor::new(&errors, &seen(0.5, 30.0, 0.0));
        let read = sensor.read(&errors, &seen(0.5, 30.0, 0.0));
        assert!((read - (0.5 * 1.1 + 0.01)).abs() < 1e-12, "{read}");
    }

    #[test]
    fn the_rate_of_a_temperature_is_that_since_the_reading_before() {
        let form = Form::Linear { slope: 1.0, origin: 0.0 };
        let terms = vec![Term { acts: Acts::Bias, driver: Driver::TemperatureRate, form }];
        let errors = SensorErrors { terms, ..SensorErrors::default() };
        let mut sensor = Sensor::new(&errors, &seen(0.0, 20.0, 0.0));
        assert_eq!(sensor.read(&errors, &seen(0.0, 20.0, 0.0)), 0.0);
        assert_eq!(sensor.read(&errors, &seen(0.0, 21.0, 4.0)), 0.25);
    }

    #[test]
    fn a_latency_has_no_place() {
        let parameters = [("latency_s".to_owned(), 0.1)].into();
        let refused = SensorErrors::of(Learned { parameters, ..Learned::default() });
        assert!(refused.unwrap_err().contains("latency_s"));
    }

    proptest! {
        /// Without errors the truth; never beyond the range; nothing within the dead zone; and a lag comes nearer and
        /// never beyond.
        #[test]
        fn limits_hold(rate in -10.0f64..10.0, first in -10.0f64..10.0, range in 0.1f64..20.0) {
            let none = SensorErrors::default();
            let mut sensor = Sensor::new(&none, &seen(first, 0.0, 0.0));
            prop_assert_eq!(sensor.read(&none, &seen(rate, 0.0, 0.1)), rate);
            let errors = SensorErrors { range, dead_zone: 0.5, time_constant_s: 1.0, ..none };
            let mut sensor = Sensor::new(&errors, &seen(first, 0.0, 0.0));
            let mut off = (first - rate).abs();
            for step in 1..50 {
                let read = sensor.read(&errors, &seen(rate, 0.0, 0.2 * f64::from(step)));
                prop_assert!(read.abs() <= range);
                prop_assert!(read == 0.0 || read.abs() >= 0.5_f64.min(range));
                let now = (sensor.lagged - rate).abs();
                prop_assert!(now <= off);
                off = now;
            }
            prop_assert!(off <= 1e-3 * (first - rate).abs() + 1e-12);
        }
    }
}
