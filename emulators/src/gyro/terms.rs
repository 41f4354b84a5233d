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

/// One term.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Term {
    /// What it acts on.
    pub acts: Acts,
    /// Its input; none for a constant.
    #[serde(default)]
    pub driver: Driver,
    /// How it depends on its input.
    pub form: Form,
    /// Range of its input: beyond it, the term is constant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within: Option<[f64; 2]>,
    /// The same of a product's second input.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within_2: Option<[f64; 2]>,
}

/// What a term acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Acts {
    /// Added to the rate, rad/s.
    Bias,
    /// Added to the scale.
    Scale,
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

/// How a term depends on its driver x.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[expect(missing_docs, reason = "each variant's formula names its fields")]
pub enum Form {
    /// `value`.
    Constant { value: f64 },
    /// `slope (x - origin)`.
    Linear { slope: f64, origin: f64 },
    /// `coefficient (x - origin)^2`.
    Quadratic { coefficient: f64, origin: f64 },
    /// `coefficient (x - origin)^3`.
    Cubic { coefficient: f64, origin: f64 },
    /// `amplitude exp(-x / time_constant)`.
    Exponential { amplitude: f64, time_constant: f64 },
    /// `cos` cos(order x) + `sin` sin(order x), for an angle.
    Harmonic { order: u8, cos: f64, sin: f64 },
    /// `cos` cos(2 pi x / period) + `sin` sin(2 pi x / period).
    Periodic { cos: f64, sin: f64, period: f64 },
    /// `size` from `at` on.
    Step { size: f64, at: f64 },
    /// `slope max(0, x - at)`.
    Hinge { slope: f64, at: f64 },
    /// `height exp(-((x - centre) / width)^2 / 2)`.
    Bump { height: f64, centre: f64, width: f64 },
    /// `height tanh((x - centre) / width)`.
    Tanh { height: f64, centre: f64, width: f64 },
    /// Linear between points, constant beyond them.
    Table { points: Vec<Point> },
    /// `coefficient (x - origin) (y - origin_2)`, y of the second driver.
    Product { coefficient: f64, origin: f64, second: Driver, origin_2: f64 },
}

/// A point of a table.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Point {
    /// Where, in the driver's unit.
    pub x: f64,
    /// The term there.
    pub value: f64,
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
    /// Its value for these inputs.
    fn value(&self, x: f64, y: f64) -> f64 {
        let held = |value: f64, range: Option<[f64; 2]>| {
            range.map_or(value, |[low, high]| value.max(low).min(high))
        };
        self.form.value(held(x, self.within), held(y, self.within_2))
    }

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
