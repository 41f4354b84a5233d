//! A lap of the square path.

use super::straight::paper_speed;
use super::turn::paper_rate;
use super::{Known, Op, StepKind};
use crate::check::PAPER_SIDE;
use crate::number;
use crate::time_limits::{MOTION_FACTOR, PERSON_LIMIT, RAMP, SLACK, TURN_RAMP, trapezoid};
use controller::mission;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::FRAC_PI_2;
use std::fmt;
use wire::time::Span;
use wire::units::{Angle, AngularRate, Length, Speed};

fn paper_side() -> Length {
    PAPER_SIDE
}

/// A lap of the square path: four straights and four turns, the absolute pose measured before and after.
/// No bias test is part of it.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Lap {
    /// Which way round.
    pub direction: Direction,
    /// Length of a side.
    #[serde(rename = "side_m", default = "paper_side", with = "number::PathLength")]
    pub side: Length,
    /// Steady speed along a side.
    #[serde(rename = "speed_m_per_s", default = "paper_speed", with = "number::Steady")]
    pub speed: Speed,
    /// Steady rate at a corner.
    #[serde(rename = "turn_rate_deg_per_s", default = "paper_rate", with = "number::Rate")]
    pub turn_rate: AngularRate,
}

/// Which way round.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// Clockwise.
    Cw,
    /// Counter-clockwise.
    Ccw,
}

impl Direction {
    /// The tag `direction`: +1 counter-clockwise, -1 clockwise.
    pub const fn sign(self) -> f64 {
        match self {
            Self::Cw => -1.0,
            Self::Ccw => 1.0,
        }
    }

    /// As written in a plan.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Cw => "cw",
            Self::Ccw => "ccw",
        }
    }
}

impl StepKind for Lap {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} lap of a {} m square", self.direction.name(), self.side.m())
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        let side = mission::Straight { distance: self.side, speed: self.speed };
        let angle = Angle::from_deg(90.0 * self.direction.sign());
        let corner = mission::Turn { angle, rate: self.turn_rate };
        let mut ops = vec![Op::AbsoluteBefore, Op::StateBefore];
        for _ in 0..4 {
            ops.extend(Op::straight(side));
            ops.extend(Op::turn(corner));
        }
        ops.extend([Op::StateAfter, Op::AbsoluteAfter, Op::ObserveLap(self.direction)]);
        Ok(ops)
    }

    fn motion(&self) -> Span {
        let side = trapezoid(self.side.m(), self.speed.m_per_s(), RAMP.m_per_s2());
        let corner = trapezoid(FRAC_PI_2, self.turn_rate.rad_per_s(), TURN_RAMP.rad_per_s2());
        (side + corner) * 4
    }

    fn limit(&self) -> Span {
        self.motion() * MOTION_FACTOR + SLACK * 8 + PERSON_LIMIT * 2
    }

    fn leaves_time_for_a_person(&self) -> bool {
        true
    }

    fn missions(&self) -> &'static [(&'static str, u64)] {
        &[("straight", 4), ("turn", 4)]
    }
}
