//! Sums of terms: slow ones once a second, the others at each output.

use super::{Acts, Driver, Form, Term};
use crate::gyro::parameters::remainder;

/// True state at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(in crate::gyro) struct Moment {
    pub(in crate::gyro) celsius: f64,
    pub(in crate::gyro) kelvin_per_s: f64,
    pub(in crate::gyro) time_s: f64,
    /// rad/s; zero if only slow terms are evaluated.
    pub(in crate::gyro) rate: f64,
    /// rad; likewise.
    pub(in crate::gyro) heading: f64,
}

/// Sums of terms.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(in crate::gyro) struct Sums {
    /// rad/s
    pub(in crate::gyro) bias: f64,
    pub(in crate::gyro) scale: f64,
}

/// State of the drivers with a memory: that of the term and of its second driver, for each term.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in crate::gyro) struct Memory(Vec<[f64; 2]>);

impl Memory {
    /// The memory of a coil that has long been at this temperature.
    pub(in crate::gyro) fn new(terms: &[Term], celsius: f64) -> Self {
        Self(vec![[celsius; 2]; terms.len()])
    }

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

    /// Interpolates between this and `end` at `share`.
    pub(in crate::gyro) fn between(&self, end: &Self, share: f64) -> Self {
        let pairs = self.0.iter().zip(&end.0);
        Self(pairs.map(|(from, to)| [0, 1].map(|i| from[i] + (to[i] - from[i]) * share)).collect())
    }

    /// The sums of the slow or of the fast terms.
    pub(in crate::gyro) fn sums(&self, terms: &[Term], moment: &Moment, fast: bool) -> Sums {
        let mut sums = Sums::default();
        for (term, memory) in terms.iter().zip(&self.0) {
            if term.is_fast() != fast {
                continue;
            }
            let x = moment.driver(term.driver, memory[0]);
            let y = moment.driver(term.form.second(), memory[1]);
            match term.acts {
                Acts::Bias => sums.bias += term.value(x, y),
                Acts::Scale => sums.scale += term.value(x, y),
            }
        }
        sums
    }
}

impl Term {
    /// True if the term must be evaluated for each output. A straight line over a second is enough for terms of
    /// temperature or time, but not for waves and steps in time.
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
