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

wire::terms! {
    points: Vec<Point, TABLE_POINTS_MAX>
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

    /// True if the term depends on the rate.
    pub(crate) fn sees_rate(&self) -> bool {
        let of_rate = |driver| matches!(driver, Driver::Rate | Driver::AbsRate | Driver::Direction);
        of_rate(self.driver) || of_rate(self.form.second())
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
