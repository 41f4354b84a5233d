//! The residual of each method of bias correction in a window at rest.

use super::bias_test::bias_test;
use super::{Known, Op, StepKind};
use crate::number;
use schemars::JsonSchema;
use serde::Deserialize;
use std::fmt;
use wire::time::Span;

/// A window at rest, compared with what each method of bias correction predicts for it: the last bias
/// test, the temperature table, and none. Changes nothing.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BiasResidual {
    /// How long to average.
    #[serde(rename = "duration_s", default = "bias_test", with = "number::Duration")]
    pub duration: Span,
}

impl StepKind for BiasResidual {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "bias residual over {} s", self.duration.as_secs_f64())
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        Ok(vec![Op::Residual(self.duration)])
    }

    fn rest(&self) -> Span {
        self.duration
    }
}
