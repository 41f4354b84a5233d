//! Stops the repetitions of a message.

use super::{Known, Op, Order, StepKind};
use crate::Checked;
use crate::survey::Survey;
use described::Place;
use schemars::JsonSchema;
use serde::Deserialize;
use std::fmt;

/// A message is no longer sent again: `stop_sending = "Command"`.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct StopSending {
    /// Its name in the layout of the device.
    pub message: String,
}

impl StepKind for StopSending {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "send no more {}", self.message)
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        Ok(vec![Op::Order(Order::StopSending(self.message.clone()))])
    }

    fn check<'a>(&'a self, survey: &mut Survey<'a>, at: &Place) -> Checked {
        survey.stopped.push((&self.message, at.clone()));
        survey.subject.message(&self.message, at)
    }
}
