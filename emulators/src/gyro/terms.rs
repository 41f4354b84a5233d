//! Error terms given in a device file: an identified model of a gyro.
//!
//! The measured rate is `(scale + sum of scale terms) x true rate + bias + sum of bias terms`. Terms use the true
//! state of the gyro: the coil's temperature instead of the sensor's, the carrier's rate and heading, the time since
//! power-up. Numbers are SI, temperatures in degrees Celsius.
//!
//! ```toml
//! [[gyro.terms]]
//! acts = "bias"
//! driver = "temperature_rate"
//! form = { linear = { slope = 0.0002, origin = 0 } }
//! ```

mod form;
mod sums;

use crate::parameters::{Domain, ParameterError, ParameterInfo, Parameters};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
pub(super) use sums::{Memory, Moment, Sums};

wire::terms! {
    #[derive(JsonSchema)]
    points: Vec<Point>
}

/// Input of a term.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Driver {
    /// No input.
    #[default]
    None,
    /// Temperature of the coil, degC.
    Temperature,
    /// Rate of change of that temperature, K/s.
    TemperatureRate,
    /// Temperature of the coil through a first-order lag, which starts settled; degC.
    TemperatureLag {
        /// Time constant of the lag.
        time_constant_s: f64,
    },
    /// Temperature with backlash, minus temperature: the branch of a hysteresis, between minus and plus the half width; K.
    /// Starts in the middle.
    TemperatureBranch {
        /// Half the width of the backlash.
        half_width_kelvin: f64,
    },
    /// The carrier's rate, rad/s.
    Rate,
    /// The carrier's rate without its sign.
    AbsRate,
    /// +1 counter-clockwise, -1 clockwise, 0 at rest.
    Direction,
    /// The carrier's heading, not wrapped; rad.
    Heading,
    /// Time since power-up, s.
    Time,
}

impl Parameters for Term {
    const TABLE: &'static [ParameterInfo] = &[];

    fn slot(&mut self, name: &str) -> Option<(&mut f64, Domain)> {
        let (_, slot, domain) = self.numbers().into_iter().find(|(known, ..)| *known == name)?;
        Some((slot, domain))
    }

    fn check(&mut self) -> Result<(), ParameterError> {
        let fault = |name: &str, value, domain| {
            Err(ParameterError::OutOfDomain { name: format!("terms: {name}"), value, domain })
        };
        for (name, value, domain) in self.numbers() {
            if !domain.contains(*value) {
                return fault(name, *value, domain);
            }
        }
        for [low, high] in self.within.into_iter().chain(self.within_2) {
            let mut rising = Domain::FINITE;
            for end in [low, high] {
                if !rising.contains(end) {
                    return fault("within", end, rising);
                }
                rising.min = end;
            }
        }
        if let Form::Table { points } = &self.form {
            let mut rising = Domain::FINITE;
            for point in points {
                if !(rising.contains(point.x) && point.value.is_finite()) {
                    return fault("points", point.x, rising);
                }
                rising.min = point.x.next_up();
            }
        }
        Ok(())
    }
}

impl Term {
    /// Its numbers by name, with their permitted values.
    fn numbers(&mut self) -> Vec<(&'static str, &mut f64, Domain)> {
        let mut numbers = self.form.numbers();
        match &mut self.driver {
            Driver::TemperatureLag { time_constant_s } => {
                numbers.push(("time_constant_s", time_constant_s, Domain::POSITIVE));
            }
            Driver::TemperatureBranch { half_width_kelvin } => {
                numbers.push(("half_width_kelvin", half_width_kelvin, Domain::POSITIVE));
            }
            _ => {}
        }
        numbers
    }
}
