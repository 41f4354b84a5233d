//! Quantities in SI units, as newtypes over `f64`.
//!
//! Inside the bench every quantity is SI. Degrees, counts and millimetres exist only at the edges: in constructors and
//! readers with the unit in their name. A quantity is serialised as its SI number, so a field's name carries the unit
//! (`heading_rad`, `speed_m_per_s`).

use crate::operator::operator;
use crate::time::Span;
use core::f64::consts::{PI, TAU};
use serde::{Deserialize, Serialize};

macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident, $from:ident, $read:ident, $unit:literal) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default, Serialize, Deserialize)]
        #[serde(transparent)]
        pub struct $name(f64);

        impl $name {
            /// Zero.
            pub const ZERO: Self = Self(0.0);

            #[doc = concat!("From a value in ", $unit, ".")]
            pub const fn $from(value: f64) -> Self {
                Self(value)
            }

            #[doc = concat!("The value in ", $unit, ".")]
            pub const fn $read(self) -> f64 {
                self.0
            }

            /// The magnitude.
            pub const fn abs(self) -> Self {
                Self(self.0.abs())
            }

            /// The smaller of two; if one is not a number, the other.
            pub const fn min(self, other: Self) -> Self {
                Self(self.0.min(other.0))
            }

            /// The larger of two; if one is not a number, the other.
            pub const fn max(self, other: Self) -> Self {
                Self(self.0.max(other.0))
            }

            /// The value limited to `limit` on either side of zero. Not-a-number is unchanged.
            pub const fn limited(self, limit: Self) -> Self {
                let limit = limit.0.abs();
                if self.0 > limit {
                    Self(limit)
                } else if self.0 < -limit {
                    Self(-limit)
                } else {
                    self
                }
            }

            /// The magnitude of `self` with the sign of `sign`.
            pub const fn copysign(self, sign: f64) -> Self {
                Self(self.0.copysign(sign))
            }

            /// Neither infinite nor not-a-number.
            pub const fn is_finite(self) -> bool {
                self.0.is_finite()
            }
        }

        operator!(Add::add, $name, $name => $name, |a, b| $name(a.0 + b.0));
        operator!(AddAssign::add_assign, $name, $name, |a, b| a + b);
        operator!(Sub::sub, $name, $name => $name, |a, b| $name(a.0 - b.0));
        operator!(SubAssign::sub_assign, $name, $name, |a, b| a - b);
        operator!(Neg::neg, $name => $name, |a| $name(-a.0));
        operator!(Mul::mul, $name, f64 => $name, |a, factor| $name(a.0 * factor));
        operator!(Div::div, $name, f64 => $name, |a, divisor| $name(a.0 / divisor));
        operator!(Div::div, $name, $name => f64, |a, b| a.0 / b.0);
    };
}

/// `$distance` = `$rate` x time.
macro_rules! rate_of {
    ($rate:ident, $distance:ident) => {
        operator!(Mul::mul, $rate, Span => $distance, |a, span| $distance(a.0 * span.as_secs_f64()));
        operator!(Div::div, $distance, Span => $rate, |a, span| $rate(a.0 / span.as_secs_f64()));
    };
}

quantity!(
    /// An angle; counter-clockwise is positive. Not wrapped unless a method says so.
    Angle, from_rad, rad, "radians"
);
quantity!(
    /// An angular rate; counter-clockwise is positive.
    AngularRate, from_rad_per_s, rad_per_s, "radians per second"
);
quantity!(
    /// An angular acceleration; counter-clockwise is positive.
    AngularAcceleration, from_rad_per_s2, rad_per_s2, "radians per second squared"
);
quantity!(
    /// A distance; forward is positive.
    Length, from_m, m, "metres"
);
quantity!(
    /// A speed along the path; forward is positive.
    Speed, from_m_per_s, m_per_s, "metres per second"
);
quantity!(
    /// An acceleration along the path.
    Acceleration, from_m_per_s2, m_per_s2, "metres per second squared"
);
quantity!(
    /// A temperature on the Celsius scale, as in the sensors and the paper.
    Temperature, from_celsius, celsius, "degrees Celsius"
);

rate_of!(AngularRate, Angle);
rate_of!(AngularAcceleration, AngularRate);
rate_of!(Speed, Length);
rate_of!(Acceleration, Speed);

const RAD_PER_DEG: f64 = PI / 180.0;
const SECONDS_PER_HOUR: f64 = 3_600.0;

impl Angle {
    /// One full turn counter-clockwise.
    pub const TURN: Self = Self(TAU);

    /// From a value in degrees.
    pub const fn from_deg(deg: f64) -> Self {
        Self(deg * RAD_PER_DEG)
    }

    /// The value in degrees.
    pub const fn deg(self) -> f64 {
        self.0 / RAD_PER_DEG
    }

    /// The same direction in [-pi, pi).
    pub fn wrapped(self) -> Self {
        let turns = libm::floor((self.0 + PI) / TAU);
        let wrapped = self.0 - turns * TAU;
        // A value a rounding error below -pi would come out as +pi.
        Self(if wrapped >= PI { wrapped - TAU } else { wrapped })
    }

    /// The sine.
    pub fn sin(self) -> f64 {
        libm::sin(self.0)
    }

    /// The cosine.
    pub fn cos(self) -> f64 {
        libm::cos(self.0)
    }
}

impl AngularRate {
    /// From a value in degrees per second.
    pub const fn from_deg_per_s(deg_per_s: f64) -> Self {
        Self(deg_per_s * RAD_PER_DEG)
    }

    /// The value in degrees per second.
    pub const fn deg_per_s(self) -> f64 {
        self.0 / RAD_PER_DEG
    }

    /// From a value in degrees per hour, the data sheets' unit of drift.
    pub const fn from_deg_per_h(deg_per_h: f64) -> Self {
        Self(deg_per_h * RAD_PER_DEG / SECONDS_PER_HOUR)
    }

    /// The value in degrees per hour.
    pub const fn deg_per_h(self) -> f64 {
        self.0 / RAD_PER_DEG * SECONDS_PER_HOUR
    }
}

impl AngularAcceleration {
    /// From a value in degrees per second squared.
    pub const fn from_deg_per_s2(deg_per_s2: f64) -> Self {
        Self(deg_per_s2 * RAD_PER_DEG)
    }

    /// The value in degrees per second squared.
    pub const fn deg_per_s2(self) -> f64 {
        self.0 / RAD_PER_DEG
    }
}

/// Position and heading on the floor.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Pose {
    /// East of the origin.
    #[serde(rename = "x_m")]
    pub x: Length,
    /// North of the origin.
    #[serde(rename = "y_m")]
    pub y: Length,
    /// Counter-clockwise from the x axis.
    #[serde(rename = "heading_rad")]
    pub heading: Angle,
}

impl Pose {
    /// True if all three numbers are finite.
    pub const fn is_finite(self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.heading.is_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::{Angle, AngularRate, Span, Speed};
    use core::f64::consts::PI;
    use proptest::prelude::*;

    #[test]
    fn degrees_enter_and_leave_by_name() {
        assert!((Angle::from_deg(180.0).rad() - PI).abs() < 1e-15);
        assert!((AngularRate::from_deg_per_s(0.005).deg_per_h() - 18.0).abs() < 1e-9);
        assert!((Speed::from_m_per_s(0.4) * Span::from_secs(10)).m() - 4.0 < 1e-12);
    }

    #[test]
    fn half_a_turn_wraps_to_the_closed_end() {
        assert_eq!(Angle::from_rad(PI).wrapped(), Angle::from_rad(-PI));
        assert_eq!(Angle::from_rad(-PI).wrapped(), Angle::from_rad(-PI));
        assert_eq!(Angle::from_rad(3.0 * PI).wrapped().rad(), -PI);
    }

    proptest! {
        #[test]
        fn a_wrapped_angle_is_the_same_direction(rad in -1e6f64..1e6) {
            let wrapped = Angle::from_rad(rad).wrapped();
            prop_assert!((-PI..PI).contains(&wrapped.rad()));
            prop_assert!((wrapped.sin() - Angle::from_rad(rad).sin()).abs() < 1e-8);
            prop_assert!((wrapped.cos() - Angle::from_rad(rad).cos()).abs() < 1e-8);
        }

        #[test]
        fn limits_hold(value in any::<f64>(), limit in 0.0f64..1e9) {
            let limited = Angle::from_rad(value).limited(Angle::from_rad(limit));
            prop_assert!(limited.rad().is_nan() == value.is_nan());
            prop_assert!(value.is_nan() || limited.abs().rad() <= limit);
        }
    }
}
