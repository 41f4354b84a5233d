//! The absolute measurement.

use super::{Known, Op, StepKind};
use crate::name::Name;
use crate::time_limits::PERSON_LIMIT;
use schemars::JsonSchema;
use serde::Deserialize;
use std::fmt;
use wire::time::Span;

/// The absolute pose is measured; this names the reading.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct MeasurePose(pub Name);

impl StepKind for MeasurePose {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "measure the absolute pose, {}", self.0)
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        Ok(vec![Op::AbsoluteNamed])
    }

    fn limit(&self) -> Span {
        PERSON_LIMIT
    }

    fn leaves_time_for_a_person(&self) -> bool {
        true
    }
}
