//! A static bias test: the gyro at rest.

use super::{Known, Op, StepKind};
use crate::number;
use controller::mission::{self, Command};
use schemars::JsonSchema;
use serde::Deserialize;
use std::fmt;
use wire::time::Span;

/// The paper's static bias test: 20 s.
pub const BIAS_TEST: Span = Span::from_secs(20);

pub(super) fn bias_test() -> Span {
    BIAS_TEST
}

/// A static bias test: the mean of the readings at rest is subtracted from now on.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BiasTest {
    /// How long to average.
    #[serde(rename = "duration_s", default = "bias_test", with = "number::Duration")]
    pub duration: Span,
}

impl StepKind for BiasTest {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "bias test of {} s", self.duration.as_secs_f64())
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        let test = mission::BiasTest { duration_s: self.duration.as_secs_f64() };
        Ok(vec![Op::mission(Command::BiasTest(test))])
    }

    fn rest(&self) -> Span {
        self.duration
    }

    fn missions(&self) -> &'static [(&'static str, u64)] {
        &[("bias_test", 1)]
    }
}
