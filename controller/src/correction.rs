//! Corrections by an identified model: the sensor's additive and scale errors as functions of what the controller can
//! observe.
//!
//! The model: measured rate = (1 + sum of scale terms) x true rate + sum of bias terms. With Eq. 4:
//!
//! ```text
//! w* = (w_raw - bias terms - w_bias) x SF x C1 x C2 ... / (1 + scale terms)
//! ```
//!
//! The static bias test measures `w_bias` on the rate minus the bias terms: the part of the bias that the model does
//! not explain.
//!
//! Numbers are SI, temperatures in degrees Celsius: the value of a bias term is in rad/s, that of a scale term has no
//! unit. A term is zero while its driver is unknown, for example temperature before the first reading.

mod form;
mod history;
mod slope;
mod watch;

use heapless::Vec;
use serde::{Deserialize, Serialize};
use wire::units::AngularRate;

pub use slope::{SLOPE_POINTS_MIN, SLOPE_WINDOW};
pub use watch::{POWER_OFF_MIN, REST_RATE};
pub(crate) use watch::{Sum, Watch};

/// Maximum number of terms in a calibration.
pub const TERMS_MAX: usize = 16;
/// Maximum number of points in a table.
pub const TABLE_POINTS_MAX: usize = 32;
/// Limit of the sum of all bias terms: the controller's largest credible bias.
pub const BIAS_SUM_MAX: AngularRate = AngularRate::from_deg_per_s(0.5);
/// Limit of the sum of all scale terms: a factor of Eq. 4 lies between 1/2 and 2.
pub const SCALE_SUM_MAX: f64 = 0.5;

/// The terms of one calibration.
pub type Corrections = Vec<Term, TERMS_MAX>;

/// One term of the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Term {
    /// The quantity that it changes.
    pub acts: Acts,
    /// Its input; none for a constant.
    #[serde(default)]
    pub driver: Driver,
    /// Its function of the input.
    pub form: Form,
    /// Range of the input: beyond it, the term is constant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within: Option<[f64; 2]>,
    /// The same of a product's second input.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within_2: Option<[f64; 2]>,
}

/// The quantity that a term changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Acts {
    /// Added to the rate, rad/s.
    Bias,
    /// Added to the scale of one.
    Scale,
}

/// Input of a term, from the controller's own measurements and clock.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Driver {
    /// No input.
    #[default]
    None,
    /// Reported temperature of the gyro, averaged over a second; degC.
    Temperature,
    /// Rate of change of the temperature, a least-squares slope over [`SLOPE_WINDOW`]; K/s.
    TemperatureRate,
    /// Temperature through a first-order lag; degC. The lag starts settled at the first temperature that the gyro
    /// reports, no matter when the calibration is loaded.
    TemperatureLag {
        /// Time constant of the lag.
        time_constant_s: f64,
    },
    /// Temperature with backlash, minus temperature: the branch of a hysteresis, between minus and plus the half
    /// width; K. Starts in the middle at the first temperature that the gyro reports.
    TemperatureBranch {
        /// Half the width of the backlash.
        half_width_kelvin: f64,
    },
    /// The corrected rate; rad/s.
    Rate,
    /// The corrected rate without its sign; rad/s.
    AbsRate,
    /// +1 counter-clockwise, -1 clockwise, 0 below [`REST_RATE`].
    Direction,
    /// The controller's own heading, not wrapped; rad.
    Heading,
    /// The bias in force, which the last bias test measured and which is subtracted; part of it may be noise; rad/s.
    /// Zero during a bias test.
    TestedBias,
    /// Time since the gyro was switched on, as far as the stream shows it: since its first sample, or since its first
    /// sample after [`POWER_OFF_MIN`] of silence; s.
    Time,
    /// Time since the controller first received a sample of the gyro; s.
    Uptime,
}

/// A term as a function of its driver x.
#[expect(clippy::large_enum_variant, reason = "no allocation: there is no box to put a table in")]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
    Table { points: Vec<Point, TABLE_POINTS_MAX> },
    /// `coefficient (x - origin) (y - origin_2)`, where y is the second driver.
    Product { coefficient: f64, origin: f64, second: Driver, origin_2: f64 },
}

/// A point of a table.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Point {
    /// The driver's value, in its unit.
    pub x: f64,
    /// The term's value at `x`.
    pub value: f64,
}

impl Term {
    /// True if every number is finite, divisors are positive, and tables and ranges rise.
    pub fn is_usable(&self) -> bool {
        let rises = |range: Option<[f64; 2]>| {
            range.is_none_or(|[low, high]| low.is_finite() && high.is_finite() && low <= high)
        };
        self.driver.is_usable()
            && self.form.is_usable()
            && rises(self.within)
            && rises(self.within_2)
            && (self.driver != Driver::None || matches!(self.form, Form::Constant { .. }))
    }

    /// Its value for these inputs.
    fn value(&self, x: f64, y: f64) -> f64 {
        let held = |value: f64, range: Option<[f64; 2]>| {
            range.map_or(value, |[low, high]| value.max(low).min(high))
        };
        self.form.value(held(x, self.within), held(y, self.within_2))
    }

    /// True if the term depends on the rate.
    pub(crate) fn sees_rate(&self) -> bool {
        let second = match &self.form {
            Form::Product { second, .. } => *second,
            _ => Driver::None,
        };
        let of_rate = |driver| matches!(driver, Driver::Rate | Driver::AbsRate | Driver::Direction);
        of_rate(self.driver) || of_rate(second)
    }
}

impl Driver {
    fn is_usable(self) -> bool {
        let positive = |value: f64| value.is_finite() && value > 0.0;
        match self {
            Self::TemperatureLag { time_constant_s } => positive(time_constant_s),
            Self::TemperatureBranch { half_width_kelvin } => positive(half_width_kelvin),
            _ => true,
        }
    }
}

#[cfg(test)]
mod tests;
