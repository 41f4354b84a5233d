//! What the contract requires of fields and kinds: names, the units of each role, the roles of each kind.

use super::{Dimension, Drive, Kind, Role};

macro_rules! named {
    ($enum:ident: $($variant:ident = $name:literal),* $(,)?) => {
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

named! { Kind: Turns = "turns", Series = "series", Odometry = "odometry", Laps = "laps",
    Sensor = "sensor",
}

named! { Drive:
    Differential = "differential", Synchro = "synchro", Skid = "skid", Tricycle = "tricycle",
}

named! { Role:
    Time = "time", Run = "run", Direction = "direction", GyroAngle = "gyro_angle", GyroRate = "gyro_rate",
    GyroCounts = "gyro_counts", GyroAngleIncrement = "gyro_angle_increment",
    ReferenceAngle = "reference_angle", ReferenceRate = "reference_rate",
    ReferenceHeading = "reference_heading", ReferenceX = "reference_x", ReferenceY = "reference_y",
    Temperature = "temperature", TableRate = "table_rate", Bias = "bias", Duration = "duration",
    Heading = "heading", WheelLeft = "wheel_left", WheelRight = "wheel_right",
    DriveDistance = "drive_distance", SteerAngle = "steer_angle", OdometryX = "odometry_x",
    OdometryY = "odometry_y", OdometryHeading = "odometry_heading", Measured = "measured", Reference = "reference", Auxiliary = "auxiliary",
    Ignore = "ignore",
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
            | Self::SteerAngle
            | Self::OdometryHeading => &[D::Angle],
            Self::GyroRate | Self::ReferenceRate | Self::TableRate | Self::Bias => {
                &[D::AngularRate]
            }
            Self::GyroCounts => &[D::Count],
            Self::ReferenceX
            | Self::ReferenceY
            | Self::OdometryX
            | Self::OdometryY
            | Self::DriveDistance => &[D::Length],
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
