//! Carries the robot to a pose.

use super::{Known, Op, Order, StepKind};
use crate::number;
use crate::time_limits::PERSON_LIMIT;
use controller::mission::Command;
use schemars::JsonSchema;
use serde::Deserialize;
use std::fmt;
use wire::time::Span;
use wire::units::{Angle, Length, Pose};

/// The robot is brought to a pose, and told so. In simulation its true pose is set; on a bench the
/// operator is asked to place it.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// Position, x.
    #[serde(rename = "x_m", with = "number::Coordinate")]
    pub x: Length,
    /// Position, y.
    #[serde(rename = "y_m", with = "number::Coordinate")]
    pub y: Length,
    /// Heading, counter-clockwise from the x axis.
    #[serde(rename = "heading_deg", with = "number::Heading")]
    pub heading: Angle,
}

impl StepKind for Place {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (x, y, heading) = (self.x.m(), self.y.m(), self.heading.deg());
        write!(f, "place the robot at {x} m, {y} m, {heading:.1} deg")
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        let pose = Pose { x: self.x, y: self.y, heading: self.heading };
        Ok(vec![Op::Order(Order::Place(pose)), Op::mission(Command::SetPose(pose))])
    }

    fn limit(&self) -> Span {
        PERSON_LIMIT
    }

    fn leaves_time_for_a_person(&self) -> bool {
        true
    }
}
