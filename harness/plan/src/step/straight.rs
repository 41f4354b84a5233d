//! A straight line of the robot.

use super::{Known, Op, StepKind};
use crate::number;
use crate::time_limits::{RAMP, trapezoid};
use controller::mission;
use schemars::JsonSchema;
use serde::Deserialize;
use std::fmt;
use wire::time::Span;
use wire::units::{Length, Speed};

/// The paper's speed of laps: 0.4 m/s (section 4.1).
pub const PAPER_SPEED: Speed = Speed::from_m_per_s(0.4);

pub(super) fn paper_speed() -> Speed {
    PAPER_SPEED
}

/// A straight line of the robot (section 4.2.1).
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Straight {
    /// How far; backward is negative.
    #[serde(rename = "distance_m", with = "number::Distance")]
    pub distance: Length,
    /// Steady speed.
    #[serde(rename = "speed_m_per_s", default = "paper_speed", with = "number::Steady")]
    pub speed: Speed,
}

impl StepKind for Straight {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "straight for {} m at {} m/s", self.distance.m(), self.speed.m_per_s())
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        let order = mission::Straight { distance: self.distance, speed: self.speed };
        Ok(Op::straight(order).into())
    }

    fn motion(&self) -> Span {
        trapezoid(self.distance.abs().m(), self.speed.m_per_s(), RAMP.m_per_s2())
    }

    fn missions(&self) -> &'static [(&'static str, u64)] {
        &[("straight", 1)]
    }
}
