//! Observations, reduced to what is drawn.

use controller::calibration::Factor;
use controller::mission::{Command, HeadingSource};

/// Larger magnitudes count as damage: no quantity of a bench comes near.
const VALUE_MAX: f64 = 1e12;

/// Whether a bench can produce this number.
pub(super) fn is_drawable(value: f64) -> bool {
    value.abs() <= VALUE_MAX
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Direction {
    /// Clockwise: the tag is negative.
    Cw,
    /// Counter-clockwise: the tag is positive.
    Ccw,
}

impl Direction {
    /// Returns the usual abbreviation.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Cw => "cw",
            Self::Ccw => "ccw",
        }
    }
}

/// Settings of the controller by the plan at the time of an observation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Conditions {
    /// The scale is corrected for temperature (Eq. 6).
    pub is_corrected: bool,
    /// Heading that closes the loops.
    pub source: HeadingSource,
}

impl Conditions {
    pub(super) fn told(&mut self, command: &Command) {
        match command {
            Command::SetHeadingSource(source) => self.source = *source,
            Command::SetCalibration(calibration) => {
                self.is_corrected = calibration
                    .factors
                    .iter()
                    .any(|factor| matches!(factor, Factor::TemperatureLine { .. }));
            }
            _ => {}
        }
    }
}

/// One observation, reduced to what is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Sample {
    pub at_s: f64,
    pub value: f64,
    pub uncertainty: f64,
    pub direction: Option<Direction>,
    pub run: Option<f64>,
    pub temperature: Option<f64>,
    /// Commanded angle of the table, deg.
    pub angle: Option<f64>,
    pub under: Conditions,
    /// Number of the set of phases in which it was made.
    pub phases: u16,
}

#[derive(Debug, Default)]
pub(super) struct Series {
    pub samples: Vec<Sample>,
    /// Number of values that are not finite, or too large.
    pub not_numbers: u64,
    /// Number of observations beyond the maximum per quantity.
    pub overflowed: u64,
}
