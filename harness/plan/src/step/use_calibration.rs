//! Puts a calibration into force.

use super::{Known, Op, StepKind};
use crate::name::Name;
use controller::calibration::Calibration;
use controller::mission::Command;
use schemars::JsonSchema;
use serde::Deserialize;
use std::fmt;

/// The name for no calibration: readings are not corrected.
pub const NO_CALIBRATION: &str = "none";

/// A calibration is used from now on: one that this plan saved, one that an earlier plan saved, or `none`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct UseCalibration(pub Name);

impl UseCalibration {
    /// Its name; `None` for [`NO_CALIBRATION`].
    pub fn name(&self) -> Option<&Name> {
        (self.0.as_str() != NO_CALIBRATION).then_some(&self.0)
    }
}

impl StepKind for UseCalibration {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.name() {
            Some(name) => write!(f, "use calibration {name}"),
            None => f.write_str("use no calibration"),
        }
    }

    fn script(&self, known: &Known<'_>) -> Result<Vec<Op>, String> {
        let calibration = match self.name().map(Name::as_str) {
            None => Calibration::default(),
            Some(name) => known
                .calibrations
                .get(name)
                .cloned()
                .ok_or_else(|| format!("no calibration \"{name}\" has been made or found"))?,
        };
        Ok(Op::mission_at_rest(Command::SetCalibration(calibration)))
    }
}
