//! Roles of fields in a data set, and the kinds of data sets: their names, the units of each role, the roles of each kind.

use super::Dimension;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Enums with the names that their variants have in a data package.
macro_rules! named {
    ($(#[$of_enum:meta])* $enum:ident { $($(#[$of_variant:meta])* $variant:ident = $name:literal,)* }) => {
        $(#[$of_enum])*
        #[derive(
            Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
        )]
        pub enum $enum { $($(#[$of_variant])* #[serde(rename = $name)] $variant,)* }

        impl $enum {
            /// Every variant.
            pub const ALL: &[Self] = &[$(Self::$variant),*];

            /// Name in a data package.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// The variant with that name.
            pub fn parse(name: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|one| one.name() == name)
            }
        }
    };
}

named! {
    /// What one row is.
    Kind {
        /// One turn of a rotary table.
        Turns = "turns",
        /// One sample of a gyro.
        Series = "series",
        /// One sample of a driven path.
        Odometry = "odometry",
        /// One lap of a closed path.
        Laps = "laps",
        /// One sample of any sensor.
        Sensor = "sensor",
    }
}

named! {
    /// How a robot is driven.
    Drive {
        /// Two wheels, each with its own speed.
        Differential = "differential",
        /// All wheels steered and driven together.
        Synchro = "synchro",
        /// Wheels of each side turn together and slip in turns; kinematics of a differential drive with an effective track.
        Skid = "skid",
        /// One steered wheel, which also drives, and an axle behind it.
        Tricycle = "tricycle",
    }
}

named! {
    /// Role of a field.
    #[expect(missing_docs, reason = "the contract's names; `Role::doc` says each")]
    Role {
        Time = "time",
        Run = "run",
        Direction = "direction",
        GyroAngle = "gyro_angle",
        GyroRate = "gyro_rate",
        GyroCounts = "gyro_counts",
        GyroAngleIncrement = "gyro_angle_increment",
        ReferenceAngle = "reference_angle",
        ReferenceRate = "reference_rate",
        ReferenceHeading = "reference_heading",
        ReferenceX = "reference_x",
        ReferenceY = "reference_y",
        Temperature = "temperature",
        TableRate = "table_rate",
        Bias = "bias",
        Duration = "duration",
        Heading = "heading",
        WheelLeft = "wheel_left",
        WheelRight = "wheel_right",
        DriveDistance = "drive_distance",
        SteerAngle = "steer_angle",
        OdometryX = "odometry_x",
        OdometryY = "odometry_y",
        OdometryHeading = "odometry_heading",
        Measured = "measured",
        Reference = "reference",
        Auxiliary = "auxiliary",
        Ignore = "ignore",
    }
}

named! {
    /// Axis of a sensor.
    #[expect(missing_docs, reason = "the names say it")]
    Axis {
        X = "x",
        Y = "y",
        Z = "z",
    }
}

impl Axis {
    /// Whether both can be of one axis: of none in particular, or of the same.
    pub(crate) fn agree(one: Option<Self>, other: Option<Self>) -> bool {
        one.is_none() || other.is_none() || one == other
    }
}

impl Role {
    /// Dimensions that a field of this role may have; empty if any.
    pub const fn dimensions(self) -> &'static [Dimension] {
        use Dimension as D;
        match self {
            Self::Time => &[D::Time, D::Number],
            Self::Duration => &[D::Time],
            Self::Direction => &[D::Number],
            Self::GyroAngle
            | Self::GyroAngleIncrement
            | Self::ReferenceAngle
            | Self::ReferenceHeading
            | Self::Heading
            | Self::OdometryHeading => &[D::Angle],
            Self::SteerAngle => &[D::Angle, D::AngularRate, D::Count],
            Self::GyroRate | Self::ReferenceRate | Self::TableRate | Self::Bias => {
                &[D::AngularRate]
            }
            Self::GyroCounts => &[D::Count],
            Self::ReferenceX | Self::ReferenceY | Self::OdometryX | Self::OdometryY => &[D::Length],
            Self::DriveDistance => &[D::Length, D::Speed, D::Count],
            Self::Temperature => &[D::Temperature],
            Self::WheelLeft | Self::WheelRight => &[D::Count, D::Angle, D::AngularRate, D::Speed],
            Self::Run | Self::Measured | Self::Reference | Self::Auxiliary | Self::Ignore => &[],
        }
    }

    /// Whether the role is a reference: its cells may be missing in any row, and it is not a cause.
    pub const fn is_reference(self) -> bool {
        matches!(
            self,
            Self::ReferenceAngle
                | Self::ReferenceRate
                | Self::ReferenceHeading
                | Self::ReferenceX
                | Self::ReferenceY
                | Self::Reference
        )
    }

    /// Whether the role is what a gyro reads, sample by sample.
    pub const fn is_gyro(self) -> bool {
        matches!(self, Self::GyroRate | Self::GyroCounts | Self::GyroAngleIncrement)
    }

    /// Whether any number of fields can have this role, with an axis or without.
    pub const fn repeats(self) -> bool {
        matches!(self, Self::Auxiliary | Self::Ignore)
    }

    /// Whether several fields can have this role, each with its own axis.
    pub const fn has_axes(self) -> bool {
        !matches!(self, Self::Time | Self::Run | Self::Direction)
    }
}

/// Groups of roles, of which one must be complete.
pub type Alternatives = &'static [&'static [Role]];

impl Kind {
    /// What a data set of this kind needs.
    pub const fn required(self) -> &'static [Alternatives] {
        use Role as R;
        match self {
            Self::Turns => &[
                &[&[R::Time]],
                &[&[R::Run]],
                &[&[R::Direction]],
                &[&[R::GyroAngle]],
                &[&[R::ReferenceAngle]],
            ],
            Self::Series => &[
                &[&[R::Time]],
                &[&[R::GyroRate], &[R::GyroCounts], &[R::GyroAngleIncrement]],
                &[&[R::ReferenceRate], &[R::ReferenceHeading]],
            ],
            Self::Odometry => &[
                &[&[R::Time]],
                &[&[R::Run]],
                &[&[R::WheelLeft, R::WheelRight], &[R::DriveDistance, R::SteerAngle]],
                &[&[R::ReferenceX]],
                &[&[R::ReferenceY]],
                &[&[R::ReferenceHeading]],
            ],
            Self::Laps => &[&[&[R::Run]], &[&[R::Direction]], &[&[R::GyroAngle]]],
            Self::Sensor => &[&[&[R::Time]], &[&[R::Measured]], &[&[R::Reference]]],
        }
    }

    /// Whether rows are samples in time: time advances from row to row of a run, and a single row carries no
    /// information.
    pub const fn is_sampled(self) -> bool {
        matches!(self, Self::Series | Self::Odometry | Self::Sensor)
    }
}

#[cfg(test)]
mod tests {
    use super::{Kind, Role};

    #[test]
    fn names_are_those_of_the_files() {
        for role in Role::ALL {
            assert_eq!(serde_json::to_value(role).ok(), Some(role.name().into()));
            assert_eq!(Role::parse(role.name()), Some(*role));
        }
        for kind in Kind::ALL {
            assert_eq!(serde_json::to_value(kind).ok(), Some(kind.name().into()));
        }
    }
}
