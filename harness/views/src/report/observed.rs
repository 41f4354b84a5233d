//! Observations, as much of them as is drawn.

use controller::calibration::Factor;
use controller::mission::{Command, HeadingSource};

/// Which way round.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Direction {
    /// Clockwise: the tag is negative.
    Cw,
    /// Counter-clockwise: the tag is positive.
    Ccw,
}

impl Direction {
    /// As everybody abbreviates it.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Cw => "cw",
            Self::Ccw => "ccw",
        }
    }
}

/// What the plan had told the controller when something was observed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Conditions {
    /// The scale is corrected for the temperature (Eq. 6).
    pub is_corrected: bool,
    /// Which heading closes the loops.
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

/// One observation, as much of it as is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Sample {
    pub at_s: f64,
    pub value: f64,
    pub uncertainty: f64,
    pub direction: Option<Direction>,
    pub run: Option<f64>,
    pub temperature: Option<f64>,
    /// Angle that the table was told to turn by, deg.
    pub angle: Option<f64>,
    pub under: Conditions,
}

/// The observations of one quantity.
#[derive(Debug, Default)]
pub(super) struct Series {
    pub samples: Vec<Sample>,
    /// Not finite, or too far from zero to be a value.
    pub not_numbers: u64,
    /// Beyond the most that are kept of one.
    pub overflowed: u64,
}
