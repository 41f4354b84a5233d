//! What terms come to: those that see slow things once a second, the others at each output.

use super::{Acts, Driver, Form, Term};
use crate::gyro::parameters::remainder;

/// What is true at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(in crate::gyro) struct Moment {
    pub(in crate::gyro) celsius: f64,
    pub(in crate::gyro) kelvin_per_s: f64,
    pub(in crate::gyro) time_s: f64,
    /// rad/s; zero where only what is slow is asked for.
    pub(in crate::gyro) rate: f64,
    /// rad; likewise.
    pub(in crate::gyro) heading: f64,
}

/// What terms come to.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(in crate::gyro) struct Sums {
    /// rad/s
    pub(in crate::gyro) bias: f64,
    pub(in crate::gyro) scale: f64,
}

/// Drivers with a memory: one of a term and one of its second driver, for each term.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in crate::gyro) struct Memory(Vec<[f64; 2]>);

impl Memory {
    /// Of a coil that has had this temperature for long.
    pub(in crate::gyro) fn new(terms: &[Term], celsius: f64) -> Self {
        Self(vec![[celsius; 2]; terms.len()])
    }

    /// `passed_s` later, the coil now at `celsius`.
    pub(in crate::gyro) fn advance(&mut self, terms: &[Term], celsius: f64, passed_s: f64) {
        for (term, memory) in terms.iter().zip(&mut self.0) {
            for (driver, state) in [term.driver, term.form.second()].into_iter().zip(memory) {
                match driver {
                    Driver::TemperatureLag { time_constant_s } => {
                        *state =
                            celsius + (*state - celsius) * remainder(passed_s, time_constant_s);
                    }
                    Driver::TemperatureBranch { half_width_kelvin: play } => {
                        *state = state.clamp(celsius - play, celsius + play);
                    }
                    _ => {}
                }
            }
        }
    }

    /// Between this and `end`, when `share` of the way is over.
    pub(in crate::gyro) fn between(&self, end: &Self, share: f64) -> Self {
        let pairs = self.0.iter().zip(&end.0);
        Self(pairs.map(|(from, to)| [0, 1].map(|i| from[i] + (to[i] - from[i]) * share)).collect())
    }

    /// What the terms come to: the slow ones, or the fast ones.
    pub(in crate::gyro) fn sums(&self, terms: &[Term], moment: &Moment, fast: bool) -> Sums {
        let mut sums = Sums::default();
        for (term, memory) in terms.iter().zip(&self.0) {
            if term.is_fast() != fast {
                continue;
            }
            let x = moment.driver(term.driver, memory[0]);
            let y = moment.driver(term.form.second(), memory[1]);
            match term.acts {
                Acts::Bias => sums.bias += term.form.value(x, y),
                Acts::Scale => sums.scale += term.form.value(x, y),
            }
        }
        sums
    }
}

impl Term {
    /// Has it to be worked out for each output? A straight line over a second does for what sees
    /// temperature or time, but not for the waves and steps that a form may make of time.
    pub(in crate::gyro) fn is_fast(&self) -> bool {
        let fast = |driver| {
            matches!(driver, Driver::Rate | Driver::AbsRate | Driver::Direction | Driver::Heading)
        };
        let sudden = matches!(self.form, Form::Periodic { .. } | Form::Step { .. });
        fast(self.driver) || fast(self.form.second()) || (self.driver == Driver::Time && sudden)
    }
}

impl Moment {
    fn driver(&self, driver: Driver, memory: f64) -> f64 {
        match driver {
            Driver::None => 0.0,
            Driver::Temperature => self.celsius,
            Driver::TemperatureRate => self.kelvin_per_s,
            Driver::TemperatureLag { .. } => memory,
            Driver::TemperatureBranch { .. } => memory - self.celsius,
            Driver::Rate => self.rate,
            Driver::AbsRate => self.rate.abs(),
            Driver::Direction if self.rate == 0.0 => 0.0,
            Driver::Direction => 1f64.copysign(self.rate),
            Driver::Heading => self.heading,
            Driver::Time => self.time_s,
        }
    }
}
