//! The correction of the gyro's rate: `w* = (w_raw - w_bias) x SF x C1 x C2 ...` (Eq. 4).
//!
//! The paper writes the bias separately; here it is subtracted first, so that the factors act on rotation alone.
//! [`Factor::TemperatureLine`] is Eq. 6: if one full turn on the table has the error `E_T = slope T + intercept` (Eq.
//! 5), then `C_T = 360 / (360 + E_T)`.

use crate::correction::{Corrections, Term};
use heapless::Vec;
use serde::ser::SerializeStruct;
use serde::{Deserialize, Serialize, Serializer};
use wire::units::{AngularRate, Temperature};

/// Maximum number of correction factors in a chain.
pub const FACTORS_MAX: usize = 8;
/// Maximum number of points in a table of bias against temperature.
pub const BIAS_POINTS_MAX: usize = 32;

/// One full turn of the table, the unit of Eqs 1 to 6, in degrees.
const TURN_DEG: f64 = 360.0;
/// Every physical correction is within this range; a factor outside it is a mistake in the file.
const FACTOR_MIN: f64 = 0.5;
const FACTOR_MAX: f64 = 2.0;

/// One correction factor of Eq. 4. Numbers are in the paper's units: degrees and degrees Celsius.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Factor {
    /// A constant factor.
    Constant(f64),
    /// Eq. 6, from the line of Eq. 5 that a temperature calibration fits.
    TemperatureLine {
        /// Slope of the error of one turn over temperature.
        slope_deg_per_celsius: f64,
        /// The error of one turn at 0 degC.
        intercept_deg: f64,
    },
    /// One factor for each direction, from the errors of one turn by Eqs 1 and 2: `C = 360 / (360 + E)`.
    Direction {
        /// E_cw: error of one clockwise turn.
        cw_error_deg: f64,
        /// E_ccw: error of one counter-clockwise turn.
        ccw_error_deg: f64,
    },
}

/// A point of the table of bias against temperature.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BiasPoint {
    /// Temperature.
    pub celsius: f64,
    /// Bias at that temperature.
    pub bias_deg_per_s: f64,
}

/// The calibration of one gyro: the content of `set_calibration` and of a calibration file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// SF of Eq. 4: the nominal scale factor.
    #[serde(default = "unity")]
    pub scale: f64,
    /// C1, C2 ... of Eq. 4.
    #[serde(default)]
    pub factors: Vec<Factor, FACTORS_MAX>,
    /// Bias against temperature, in order of temperature; may be empty.
    #[serde(default)]
    pub bias_table: Vec<BiasPoint, BIAS_POINTS_MAX>,
    /// Terms of an identified model, applied beside the factors; see [`crate::correction`].
    #[serde(default)]
    pub corrections: Corrections,
}

impl Serialize for Calibration {
    /// Text formats omit an empty list of corrections; formats read by position include it.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let with_corrections = !serializer.is_human_readable() || !self.corrections.is_empty();
        let fields = 3 + usize::from(with_corrections);
        let mut calibration = serializer.serialize_struct("Calibration", fields)?;
        calibration.serialize_field("scale", &self.scale)?;
        calibration.serialize_field("factors", &self.factors)?;
        calibration.serialize_field("bias_table", &self.bias_table)?;
        if with_corrections {
            calibration.serialize_field("corrections", &self.corrections)?;
        }
        calibration.end()
    }
}

fn unity() -> f64 {
    1.0
}

impl Default for Calibration {
    fn default() -> Self {
        Self {
            scale: 1.0,
            factors: Vec::new(),
            bias_table: Vec::new(),
            corrections: Corrections::new(),
        }
    }
}

impl Calibration {
    /// True if every number is finite, every factor is plausible over -40 to +85 degC, the table is in order of
    /// temperature, and every correction is usable.
    pub fn is_usable(&self) -> bool {
        let cold = Some(Temperature::from_celsius(-40.0));
        let hot = Some(Temperature::from_celsius(85.0));
        let plausible = |factor: f64| (FACTOR_MIN..=FACTOR_MAX).contains(&factor);
        plausible(self.scale)
            && self.factors.iter().all(|factor| {
                [cold, hot].iter().all(|&t| plausible(factor.value(t, 1.0)))
                    && plausible(factor.value(cold, -1.0))
            })
            && self.bias_table.iter().all(|p| p.celsius.is_finite() && p.bias_deg_per_s.is_finite())
            && self.bias_table.windows(2).all(|pair| pair[0].celsius < pair[1].celsius)
            && self.corrections.iter().all(Term::is_usable)
    }

    /// SF x C1 x C2 ... for a rotation in the direction of `rate` at `temperature`. A factor that needs a temperature
    /// counts as one until a temperature is known.
    pub fn gain(&self, temperature: Option<Temperature>, rate: AngularRate) -> f64 {
        let direction = rate.rad_per_s();
        self.factors
            .iter()
            .fold(self.scale, |gain, factor| gain * factor.value(temperature, direction))
    }

    /// True if a factor depends on temperature.
    pub fn needs_temperature(&self) -> bool {
        self.factors.iter().any(|factor| matches!(factor, Factor::TemperatureLine { .. }))
    }

    /// The bias from the table at `temperature`: linear between points, constant beyond them.
    pub fn table_bias(&self, temperature: Temperature) -> Option<AngularRate> {
        let t = temperature.celsius();
        let first = self.bias_table.first()?;
        let above = self.bias_table.iter().position(|point| point.celsius >= t);
        let bias = match above {
            Some(0) => first.bias_deg_per_s,
            Some(index) => {
                let (low, high) = (self.bias_table[index - 1], self.bias_table[index]);
                let share = (t - low.celsius) / (high.celsius - low.celsius);
                low.bias_deg_per_s + share * (high.bias_deg_per_s - low.bias_deg_per_s)
            }
            None => self.bias_table.last()?.bias_deg_per_s,
        };
        Some(AngularRate::from_deg_per_s(bias))
    }
}

impl Factor {
    fn value(self, temperature: Option<Temperature>, direction: f64) -> f64 {
        match self {
            Self::Constant(factor) => factor,
            Self::TemperatureLine { slope_deg_per_celsius, intercept_deg } => match temperature {
                Some(t) => {
                    TURN_DEG / (TURN_DEG + intercept_deg + slope_deg_per_celsius * t.celsius())
                }
                None => 1.0,
            },
            Self::Direction { cw_error_deg, ccw_error_deg } => {
                let error = if direction < 0.0 { cw_error_deg } else { ccw_error_deg };
                TURN_DEG / (TURN_DEG + error)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{AngularRate, BiasPoint, Calibration, Factor, Temperature};
    use proptest::prelude::*;

    fn paper() -> Factor {
        Factor::TemperatureLine { slope_deg_per_celsius: -0.52, intercept_deg: 19.23 }
    }

    fn with(factors: &[Factor]) -> Calibration {
        Calibration { factors: factors.iter().copied().collect(), ..Calibration::default() }
    }

    #[test]
    fn eq_6_is_360_over_379_23_minus_0_52_t() {
        let calibration = with(&[paper()]);
        for t in [15.0, 25.0, 36.98, 45.0] {
            let expected = 360.0 / (379.23 - 0.52 * t);
            let gain = calibration.gain(Some(Temperature::from_celsius(t)), AngularRate::ZERO);
            assert!((gain - expected).abs() < 1e-12, "{t} degC: {gain} != {expected}");
        }
        assert_eq!(calibration.gain(None, AngularRate::ZERO), 1.0);
    }

    #[test]
    fn factors_chain_as_in_eq_4() {
        let t = Some(Temperature::from_celsius(25.0));
        let mut calibration = with(&[paper(), Factor::Constant(0.98)]);
        calibration.scale = 1.01;
        let expected = 1.01 * (360.0 / (379.23 - 0.52 * 25.0)) * 0.98;
        assert!((calibration.gain(t, AngularRate::ZERO) - expected).abs() < 1e-12);
    }

    #[test]
    fn each_direction_has_its_own_factor() {
        // Eqs 1 and 2: a turn read as 361 deg ccw and 358 deg cw.
        let calibration = with(&[Factor::Direction { cw_error_deg: -2.0, ccw_error_deg: 1.0 }]);
        let ccw = calibration.gain(None, AngularRate::from_deg_per_s(30.0));
        let cw = calibration.gain(None, AngularRate::from_deg_per_s(-30.0));
        assert!((ccw * 361.0 - 360.0).abs() < 1e-9);
        assert!((cw * 358.0 - 360.0).abs() < 1e-9);
    }

    #[test]
    fn the_table_is_linear_between_points_and_constant_beyond() {
        let mut calibration = Calibration::default();
        assert_eq!(calibration.table_bias(Temperature::from_celsius(20.0)), None);
        for (celsius, bias_deg_per_s) in [(20.0, 0.01), (30.0, 0.03), (40.0, 0.02)] {
            calibration.bias_table.push(BiasPoint { celsius, bias_deg_per_s }).unwrap();
        }
        for (t, expected) in [(0.0, 0.01), (20.0, 0.01), (25.0, 0.02), (35.0, 0.025), (90.0, 0.02)]
        {
            let bias = calibration.table_bias(Temperature::from_celsius(t)).unwrap();
            assert!((bias.deg_per_s() - expected).abs() < 1e-12, "{t} degC");
        }
    }

    #[test]
    fn a_mistake_in_a_file_is_not_usable() {
        assert!(with(&[paper()]).is_usable());
        assert!(!with(&[Factor::Constant(f64::NAN)]).is_usable());
        assert!(
            !with(&[Factor::Direction { cw_error_deg: -360.0, ccw_error_deg: 0.0 }]).is_usable()
        );
        let swapped =
            Factor::TemperatureLine { slope_deg_per_celsius: 19.23, intercept_deg: -0.52 };
        assert!(!with(&[swapped]).is_usable());
        let mut falling = Calibration::default();
        for celsius in [30.0, 20.0] {
            falling.bias_table.push(BiasPoint { celsius, bias_deg_per_s: 0.0 }).unwrap();
        }
        assert!(!falling.is_usable());
    }

    proptest! {
        #[test]
        fn a_usable_calibration_never_gives_nonsense(
            slope in -2.0f64..2.0, intercept in -100.0f64..100.0, t in -40.0f64..85.0,
        ) {
            let calibration = with(&[Factor::TemperatureLine {
                slope_deg_per_celsius: slope, intercept_deg: intercept,
            }]);
            prop_assume!(calibration.is_usable());
            let gain = calibration.gain(Some(Temperature::from_celsius(t)), AngularRate::ZERO);
            prop_assert!((0.4..=2.5).contains(&gain));
        }
    }
}
