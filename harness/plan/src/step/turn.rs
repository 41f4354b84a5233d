//! A turn of the robot.

use super::{Known, Op, StepKind};
use crate::number;
use crate::time_limits::{TURN_RAMP, trapezoid};
use controller::mission;
use schemars::JsonSchema;
use serde::Deserialize;
use std::fmt;
use wire::time::Span;
use wire::units::{Angle, AngularRate};

/// The paper's rate of turns, on the table and on the robot: 30 deg/s.
pub const PAPER_RATE: AngularRate = AngularRate::from_deg_per_s(30.0);

pub(super) fn paper_rate() -> AngularRate {
    PAPER_RATE
}

/// A turn of the robot on the spot (section 4.2.2).
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Turn {
    /// How far; counter-clockwise is positive.
    #[serde(rename = "angle_deg", with = "number::Turn")]
    pub angle: Angle,
    /// Steady rate.
    #[serde(rename = "rate_deg_per_s", default = "paper_rate", with = "number::Rate")]
    pub rate: AngularRate,
}

impl StepKind for Turn {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "turn by {:.1} deg at {:.1} deg/s", self.angle.deg(), self.rate.deg_per_s())
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        Ok(Op::turn(mission::Turn { angle: self.angle, rate: self.rate }).into())
    }

    fn motion(&self) -> Span {
        trapezoid(self.angle.abs().rad(), self.rate.rad_per_s(), TURN_RAMP.rad_per_s2())
    }

    fn missions(&self) -> &'static [(&'static str, u64)] {
        &[("turn", 1)]
    }
}
