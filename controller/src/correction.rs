//! Corrections by a model that was identified: what the sensor adds to the rate, and how its scale
//! errs, as functions of what a controller can see.
//!
//! The model says: measured rate = (1 + sum of scale terms) x true rate + sum of bias terms. So with
//! Eq. 4
//!
//! ```text
//! w* = (w_raw - bias terms - w_bias) x SF x C1 x C2 ... / (1 + scale terms)
//! ```
//!
//! where the static bias test measures `w_bias` of the rate less the bias terms: what the model does
//! not know of the bias.
//!
//! Numbers are SI, temperatures in degrees Celsius: the value of a bias term is in rad/s, that of a
//! scale term a plain number. A term whose driver is not known yet, temperature before the first
//! reading say, is zero.

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

/// Most terms of one calibration.
pub const TERMS_MAX: usize = 16;
/// Most points of one table.
pub const TABLE_POINTS_MAX: usize = 32;
/// The bias terms together never say more than this: the controller's largest credible bias.
pub const BIAS_SUM_MAX: AngularRate = AngularRate::from_deg_per_s(0.5);
/// The scale terms together never say more than this: a factor of Eq. 4 lies between 1/2 and 2.
pub const SCALE_SUM_MAX: f64 = 0.5;

/// The terms of one calibration.
pub type Corrections = Vec<Term, TERMS_MAX>;

/// One term of the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Term {
    /// What it acts on.
    pub acts: Acts,
    /// What it sees; nothing, for a constant.
    #[serde(default)]
    pub driver: Driver,
    /// How it depends on that.
    pub form: Form,
}

/// What a term acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Acts {
    /// It is added to the rate, rad/s.
    Bias,
    /// It is added to the scale of one.
    Scale,
}

/// What a term sees: by the controller's own measurements and clock.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Driver {
    /// Nothing.
    #[default]
    None,
    /// Temperature that the gyro tells, mean of a second; degC.
    Temperature,
    /// Its rate of change, a least-squares slope over [`SLOPE_WINDOW`]; K/s.
    TemperatureRate,
    /// It, through a first-order lag; degC. The lag starts without a difference at the first
    /// temperature that the gyro tells, whenever the calibration is loaded.
    TemperatureLag {
        /// Time constant of the lag.
        time_constant_s: f64,
    },
    /// It with play, less it: the branch of a hysteresis, at most the half width either way; K. Starts
    /// in the middle at the first temperature that the gyro tells.
    TemperatureBranch {
        /// Half of the play.
        half_width_kelvin: f64,
    },
    /// The corrected rate; rad/s.
    Rate,
    /// The same without its sign.
    AbsRate,
    /// +1 counter-clockwise, -1 clockwise, 0 below [`REST_RATE`].
    Direction,
    /// The controller's own heading, not wrapped; rad.
    Heading,
    /// The bias in force, which a bias test found and is subtracted: what it found may be part noise;
    /// rad/s. Zero while a bias test looks for a new one.
    TestedBias,
    /// Time since the gyro was switched on, as far as it can be heard: since its first sample, or its
    /// first after [`POWER_OFF_MIN`] of silence; s.
    Time,
    /// Time since the controller first heard the gyro; s.
    Uptime,
}

/// How a term depends on its driver x.
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
    /// `coefficient (x - origin) (y - origin_2)`, y of the second driver.
    Product { coefficient: f64, origin: f64, second: Driver, origin_2: f64 },
}

/// A point of a table.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Point {
    /// Where, in the driver's unit.
    pub x: f64,
    /// The term there.
    pub value: f64,
}

impl Term {
    /// Every number is finite, what divides is above zero, and tables rise.
    pub fn is_usable(&self) -> bool {
        self.driver.is_usable()
            && self.form.is_usable()
            && (self.driver != Driver::None || matches!(self.form, Form::Constant { .. }))
    }

    /// Does it see the rate?
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
