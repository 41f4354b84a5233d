//! Sets a parameter of a device.

use super::{Known, Op, Order, StepKind};
use crate::Checked;
use crate::name::ParameterName;
use crate::number;
use crate::survey::Survey;
use crate::time_limits::PERSON_LIMIT;
use described::Place;
use schemars::JsonSchema;
use serde::Deserialize;
use std::fmt;
use wire::time::Span;

/// A parameter is set until it is set again. In simulation the world does so; on a bench the operator is
/// asked to.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SetParameter {
    /// Which.
    pub parameter: ParameterName,
    /// To what.
    #[serde(with = "number::Finite")]
    pub value: f64,
}

impl StepKind for SetParameter {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "set {} to {}", self.parameter, self.value)
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        Ok(vec![Op::Order(Order::set(&self.parameter, self.value))])
    }

    fn check<'a>(&'a self, survey: &mut Survey<'a>, at: &Place) -> Checked {
        survey.subject.parameter(&self.parameter, &[self.value], at)
    }

    fn limit(&self) -> Span {
        PERSON_LIMIT
    }
}

impl Order {
    pub(super) fn set(parameter: &ParameterName, value: f64) -> Self {
        let ParameterName { device, parameter } = parameter;
        Self::SetParameter { device: device.to_string(), parameter: parameter.to_string(), value }
    }
}
