//! Switches a device off and on again.

use super::{Known, Op, Order, StepKind};
use crate::Checked;
use crate::name::Name;
use crate::number;
use crate::survey::Survey;
use crate::time_limits::PERSON_LIMIT;
use described::Place;
use schemars::JsonSchema;
use serde::Deserialize;
use std::fmt;
use wire::time::Span;

/// A device is switched off and on again: cold after a long pause, hot after a short one. A program under test is killed,
/// and started again.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PowerCycle {
    /// Role of the device.
    pub device: Name,
    /// How long it stays off.
    #[serde(rename = "off_s", with = "number::Duration")]
    pub off: Span,
}

impl StepKind for PowerCycle {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "switch the {} off for {} s", self.device, self.off.as_secs_f64())
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        let device = self.device.as_str().to_owned();
        Ok(vec![Op::Order(Order::PowerCycle { device, off: self.off })])
    }

    fn check<'a>(&'a self, survey: &mut Survey<'a>, at: &Place) -> Checked {
        survey.subject.supply(self.device.as_str(), at)
    }

    fn rest(&self) -> Span {
        self.off
    }

    fn limit(&self) -> Span {
        self.off + PERSON_LIMIT
    }
}
