//! Waits for a time.

use super::{Known, Op, StepKind};
use crate::number;
use schemars::JsonSchema;
use serde::Deserialize;
use std::fmt;
use wire::time::Span;

/// Nothing happens.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Wait {
    /// For so long.
    #[serde(rename = "duration_s", with = "number::Duration")]
    pub duration: Span,
}

impl StepKind for Wait {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "wait {} s", self.duration.as_secs_f64())
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        Ok(vec![Op::Pause(self.duration)])
    }

    fn rest(&self) -> Span {
        self.duration
    }
}
