//! Steps that move something: the base, the table, or the robot as a whole.

use super::name::Name;
use super::number;
use schemars::JsonSchema;
use serde::Deserialize;
use wire::units::{Angle, AngularAcceleration, AngularRate, Length, Speed};

/// The paper's rate of turns, on the table and on the robot: 30 deg/s.
pub const PAPER_RATE: AngularRate = AngularRate::from_deg_per_s(30.0);
/// The paper's speed of laps: 0.4 m/s (section 4.1).
pub const PAPER_SPEED: Speed = Speed::from_m_per_s(0.4);
/// Ramps of the table. Assumption: 15 deg/s^2 give the paper's 48 s for one run.
pub const TABLE_ACCELERATION: AngularAcceleration = AngularAcceleration::from_deg_per_s2(15.0);

fn paper_rate() -> AngularRate {
    PAPER_RATE
}

fn paper_speed() -> Speed {
    PAPER_SPEED
}

fn paper_side() -> Length {
    super::check::PAPER_SIDE
}

fn table_acceleration() -> AngularAcceleration {
    TABLE_ACCELERATION
}

/// A turn of the robot on the spot (section 4.2.2).
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Turn {
    /// How far; counter-clockwise is positive.
    #[serde(rename = "angle_deg", deserialize_with = "number::turn")]
    #[schemars(schema_with = "number::schema::turn")]
    pub angle: Angle,
    /// Steady rate.
    #[serde(rename = "rate_deg_per_s", default = "paper_rate", deserialize_with = "number::rate")]
    #[schemars(
        schema_with = "number::schema::rate",
        extend("default" = number::schema::written(PAPER_RATE.deg_per_s()))
    )]
    pub rate: AngularRate,
}

/// A straight line of the robot (section 4.2.1).
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Straight {
    /// How far; backward is negative.
    #[serde(rename = "distance_m", deserialize_with = "number::distance")]
    #[schemars(schema_with = "number::schema::distance")]
    pub distance: Length,
    /// Steady speed.
    #[serde(rename = "speed_m_per_s", default = "paper_speed", deserialize_with = "number::speed")]
    #[schemars(
        schema_with = "number::schema::speed",
        extend("default" = number::schema::written(PAPER_SPEED.m_per_s()))
    )]
    pub speed: Speed,
}

/// A lap of the square path: four straights and four turns, the absolute pose measured before and after.
/// No bias test is part of it.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Lap {
    /// Which way round.
    pub direction: Direction,
    /// Length of a side.
    #[serde(rename = "side_m", default = "paper_side", deserialize_with = "number::length")]
    #[schemars(
        schema_with = "number::schema::length",
        extend("default" = number::schema::written(super::check::PAPER_SIDE.m()))
    )]
    pub side: Length,
    /// Steady speed along a side.
    #[serde(rename = "speed_m_per_s", default = "paper_speed", deserialize_with = "number::speed")]
    #[schemars(
        schema_with = "number::schema::speed",
        extend("default" = number::schema::written(PAPER_SPEED.m_per_s()))
    )]
    pub speed: Speed,
    /// Steady rate at a corner.
    #[serde(
        rename = "turn_rate_deg_per_s",
        default = "paper_rate",
        deserialize_with = "number::rate"
    )]
    #[schemars(
        schema_with = "number::schema::rate",
        extend("default" = number::schema::written(PAPER_RATE.deg_per_s()))
    )]
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

/// A turn of the rotary table, the gyro on it (Eqs 1 and 2).
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TableTurn {
    /// How far; counter-clockwise is positive.
    #[serde(rename = "angle_deg", deserialize_with = "number::turn")]
    #[schemars(schema_with = "number::schema::turn")]
    pub angle: Angle,
    /// Steady rate.
    #[serde(rename = "rate_deg_per_s", default = "paper_rate", deserialize_with = "number::rate")]
    #[schemars(
        schema_with = "number::schema::rate",
        extend("default" = number::schema::written(PAPER_RATE.deg_per_s()))
    )]
    pub rate: AngularRate,
    /// Ramps.
    #[serde(
        rename = "acceleration_deg_per_s2",
        default = "table_acceleration",
        deserialize_with = "number::angular_acceleration"
    )]
    #[schemars(
        schema_with = "number::schema::angular_acceleration",
        extend("default" = number::schema::written(TABLE_ACCELERATION.deg_per_s2()))
    )]
    pub acceleration: AngularAcceleration,
}

/// The robot is brought to a pose, and told so. In simulation its true pose is set; on a bench the
/// operator is asked to place it.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// Position, x.
    #[serde(rename = "x_m", deserialize_with = "number::coordinate")]
    #[schemars(schema_with = "number::schema::coordinate")]
    pub x: Length,
    /// Position, y.
    #[serde(rename = "y_m", deserialize_with = "number::coordinate")]
    #[schemars(schema_with = "number::schema::coordinate")]
    pub y: Length,
    /// Heading, counter-clockwise from the x axis.
    #[serde(rename = "heading_deg", deserialize_with = "number::heading")]
    #[schemars(schema_with = "number::schema::heading")]
    pub heading: Angle,
}

/// The absolute pose is measured; this names the reading.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct MeasurePose(pub Name);
