//! Makes a calibration from fits.

use super::{Known, Op, StepKind};
use crate::Checked;
use crate::name::Name;
use crate::survey::Survey;
use described::Place;
use described::hint::proposal;
use schemars::JsonSchema;
use serde::Deserialize;
use std::fmt;

/// Fits become a calibration, which the run folder keeps and later steps and plans can use.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SaveCalibration {
    /// Its name.
    pub name: Name,
    /// Fits that were made earlier in the plan, in the order in which their factors are applied.
    pub from: Vec<Name>,
}

impl StepKind for SaveCalibration {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "save calibration {}", self.name)
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        Ok(vec![Op::SaveCalibration(self.clone())])
    }

    fn check<'a>(&'a self, survey: &mut Survey<'a>, at: &Place) -> Checked {
        if self.from.is_empty() {
            let message = "a calibration from nothing, expected at least one fit".to_owned();
            return Err(at.key("from").mistake(message));
        }
        for (index, name) in self.from.iter().enumerate() {
            let here = at.key("from").index(index);
            let Some((of, has_place)) = survey.fits.get(name.as_str()) else {
                let known: Vec<_> = survey.fits.keys().copied().collect();
                let help = proposal(name.as_str(), &known);
                return Err(here.mistake(format!("no fit `{name}` before this step")).help(help));
            };
            if !has_place {
                return Err(here.mistake(format!("a calibration has no place for a {of}")));
            }
        }
        Ok(())
    }
}
