//! Roles of fields in a data set, and the kinds of data sets.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What one row is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// One turn of a rotary table.
    Turns,
    /// One sample of a gyro.
    Series,
    /// One sample of a driven path.
    Odometry,
    /// One lap of a closed path.
    Laps,
    /// One sample of any sensor.
    Sensor,
}

/// How a robot is driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Drive {
    /// Two wheels, each with its own speed.
    Differential,
    /// All wheels steered and driven together.
    Synchro,
    /// Wheels of each side turn together and slip in turns; kinematics of a differential drive with an effective track.
    Skid,
    /// One steered wheel, which also drives, and an axle behind it.
    Tricycle,
}

/// Axis of a sensor.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "the names say it")]
pub enum Axis {
    X,
    Y,
    Z,
}

/// Role of a field.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "the contract's names; `Role::doc` says each")]
pub enum Role {
    Time,
    Run,
    Direction,
    GyroAngle,
    GyroRate,
    GyroCounts,
    GyroAngleIncrement,
    ReferenceAngle,
    ReferenceRate,
    ReferenceHeading,
    ReferenceX,
    ReferenceY,
    Temperature,
    TableRate,
    Bias,
    Duration,
    Heading,
    WheelLeft,
    WheelRight,
    DriveDistance,
    SteerAngle,
    OdometryX,
    OdometryY,
    OdometryHeading,
    Measured,
    Reference,
    Auxiliary,
    Ignore,
}

impl Axis {
    /// Whether both can be of one axis: of none in particular, or of the same.
    pub(crate) fn agree(one: Option<Self>, other: Option<Self>) -> bool {
        one.is_none() || other.is_none() || one == other
    }
}
