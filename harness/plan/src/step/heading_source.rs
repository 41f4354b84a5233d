//! Selects the heading that closes the loops.

use super::{Known, Op, StepKind};
use controller::mission::{Command, HeadingSource};
use schemars::JsonSchema;
use std::fmt;

/// [`controller::mission::HeadingSource`], as it is written.
#[derive(JsonSchema)]
#[schemars(rename = "HeadingSource", rename_all = "snake_case")]
#[schemars(description = "Which heading closes the loops.")]
#[expect(dead_code, reason = "it is only described")]
pub(super) enum Word {
    /// The gyro's.
    Gyro,
    /// The base's own odometry.
    Odometry,
}

impl StepKind for HeadingSource {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Gyro => "heading from the gyro",
            Self::Odometry => "heading from odometry",
        })
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        Ok(vec![Op::mission(Command::SetHeadingSource(*self))])
    }
}
