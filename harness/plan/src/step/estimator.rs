//! Selects the estimator of heading, position and bias.

use super::{Known, Op, StepKind};
use controller::mission::{Command, Estimator};
use schemars::JsonSchema;
use std::fmt;

/// [`controller::mission::Estimator`], as it is written.
#[derive(JsonSchema)]
#[schemars(rename = "Estimator", rename_all = "snake_case")]
#[schemars(description = "What estimates heading, position and bias.")]
#[expect(dead_code, reason = "it is only described")]
pub(super) enum Word {
    /// As in the paper: samples less the bias of the last test, summed.
    Paper,
    /// A Kalman filter, which learns at every standstill.
    Kalman,
}

impl StepKind for Estimator {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Paper => "estimates as in the paper",
            Self::Kalman => "estimates by a Kalman filter",
        })
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        Ok(Op::mission_at_rest(Command::SetEstimator(*self)))
    }
}
