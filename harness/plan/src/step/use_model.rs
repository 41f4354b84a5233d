//! Puts an identified model into force.

use super::use_calibration::NO_CALIBRATION;
use super::{Known, Op, StepKind};
use crate::name::Name;
use schemars::JsonSchema;
use serde::Deserialize;
use std::fmt;

/// The controller corrects by an identified model from now on, on top of the calibration in force: by one
/// that this plan or an earlier one identified, or by `none`. A calibration that is used later takes its
/// place. A model of a sensor has the node that is emulated take its errors off before it sends; on a real node a person
/// is asked to.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct UseModel(pub Name);

impl UseModel {
    /// Its name; `None` for [`NO_CALIBRATION`].
    pub fn name(&self) -> Option<&Name> {
        (self.0.as_str() != NO_CALIBRATION).then_some(&self.0)
    }
}

impl StepKind for UseModel {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.name() {
            Some(name) => write!(f, "use model {name}"),
            None => f.write_str("use no model"),
        }
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        Ok(vec![Op::Rest, Op::UseModel(self.name().map(|name| name.as_str().to_owned()))])
    }
}
