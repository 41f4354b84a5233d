//! Waits for a time.

use super::{Known, Needs, Op, StepKind};
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
    #[serde(rename = "duration_s", deserialize_with = "number::duration")]
    #[schemars(schema_with = "number::schema::duration")]
    pub duration: Span,
}

impl StepKind for Wait {
    fn example() -> &'static str {
        "{ wait = { duration_s = 60 } }"
    }

    fn needs() -> Needs {
        Needs::Nothing
    }

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
