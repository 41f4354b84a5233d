//! Numbers of a plan file: checked against bounds during parsing, in SI units from then on.
//!
//! Each function is a serde `deserialize_with`. A value out of bounds is rejected there, so that the error contains its
//! place in the file.

pub(crate) mod schema;

use serde::Deserializer;
use serde::de::{self, Unexpected, Visitor};
use std::fmt;
use wire::time::Span;
use wire::units::{Acceleration, Angle, AngularAcceleration, AngularRate, Length, Speed};

/// Longest duration in a plan: 31 days. Assumption: a longer one is an error of units.
pub const DURATION_MAX_S: f64 = 31.0 * 86_400.0;
/// Shortest period of a sent message. Assumption: a shorter one fills a CAN bus of 500 kbit/s.
pub const SENDING_PERIOD_MIN_S: f64 = 0.001;
/// Largest angle of one motion: 100 turns. Assumption: a larger one is an error of units.
pub const ANGLE_MAX_DEG: f64 = 36_000.0;
/// Largest rate of one motion, in deg/s. Assumption: ten times the range of the paper's gyro.
pub const RATE_MAX_DEG_PER_S: f64 = 1_000.0;
/// Largest angular acceleration, in deg/s^2. Assumption: more than any stepper table reaches.
pub const ANGULAR_ACCELERATION_MAX_DEG_PER_S2: f64 = 10_000.0;
/// Largest coordinate or distance, in metres. Assumption: larger than any test floor.
pub const DISTANCE_MAX_M: f64 = 1_000.0;
/// Largest speed, in m/s. Assumption: far beyond the 0.78 m/s of the K2A.
pub const SPEED_MAX_M_PER_S: f64 = 10.0;
/// Largest acceleration, in m/s^2. Assumption: ten times gravity, more than any wheeled robot reaches.
pub const ACCELERATION_MAX_M_PER_S2: f64 = 100.0;

/// A finite number that `accept` allows; `expected` describes the allowed values.
struct Number<F> {
    expected: &'static str,
    accept: F,
}

impl<F: Fn(f64) -> bool> Visitor<'_> for Number<F> {
    type Value = f64;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.expected)
    }

    fn visit_f64<E: de::Error>(self, value: f64) -> Result<f64, E> {
        if value.is_finite() && (self.accept)(value) {
            Ok(value)
        } else {
            Err(E::invalid_value(Unexpected::Float(value), &self.expected))
        }
    }

    fn visit_i64<E: de::Error>(self, value: i64) -> Result<f64, E> {
        if (self.accept)(value as f64) {
            Ok(value as f64)
        } else {
            Err(E::invalid_value(Unexpected::Signed(value), &self.expected))
        }
    }
}

fn read<'de, D: Deserializer<'de>>(
    deserializer: D,
    expected: &'static str,
    accept: impl Fn(f64) -> bool,
) -> Result<f64, D::Error> {
    deserializer.deserialize_f64(Number { expected, accept })
}

/// Any finite number.
pub(super) fn finite<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    read(d, "a finite number", |_| true)
}

/// A finite number, or none.
pub(super) fn finite_option<'de, D: Deserializer<'de>>(d: D) -> Result<Option<f64>, D::Error> {
    finite(d).map(Some)
}

/// A number above zero.
pub(super) fn positive<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    read(d, "a number above zero", |x| x > 0.0)
}

/// A share of a whole: above 0, at most 1.
pub(crate) fn share<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    read(d, "a share above 0 and at most 1", |x| x > 0.0 && x <= 1.0)
}

/// Seconds above zero.
pub(super) fn duration<'de, D: Deserializer<'de>>(d: D) -> Result<Span, D::Error> {
    read(d, "a number of seconds above 0, at most 31 days", |x| x > 0.0 && x <= DURATION_MAX_S)
        .map(Span::from_secs_f64)
}

/// Seconds above zero, or none.
pub(crate) fn duration_option<'de, D: Deserializer<'de>>(d: D) -> Result<Option<Span>, D::Error> {
    duration(d).map(Some)
}

/// Seconds, zero or above.
pub(crate) fn duration_or_zero<'de, D: Deserializer<'de>>(d: D) -> Result<Span, D::Error> {
    read(d, "a number of seconds, 0 to 31 days", |x| (0.0..=DURATION_MAX_S).contains(&x))
        .map(Span::from_secs_f64)
}

/// The period of a message in seconds, or zero to send it once.
pub(super) fn sending_period<'de, D: Deserializer<'de>>(d: D) -> Result<Option<Span>, D::Error> {
    let accept = |x: f64| x == 0.0 || (SENDING_PERIOD_MIN_S..=DURATION_MAX_S).contains(&x);
    read(d, "0, or a number of seconds from 0.001 to 31 days", accept)
        .map(|x| Some(Span::from_secs_f64(x)))
}

/// Degrees of a turn, not zero.
pub(super) fn turn<'de, D: Deserializer<'de>>(d: D) -> Result<Angle, D::Error> {
    read(d, "degrees, not 0, at most 36000 either way", |x| x != 0.0 && x.abs() <= ANGLE_MAX_DEG)
        .map(Angle::from_deg)
}

/// Degrees of a heading.
pub(super) fn heading<'de, D: Deserializer<'de>>(d: D) -> Result<Angle, D::Error> {
    read(d, "a heading of -360 to 360 degrees", |x| x.abs() <= 360.0).map(Angle::from_deg)
}

/// Degrees per second above zero.
pub(super) fn rate<'de, D: Deserializer<'de>>(d: D) -> Result<AngularRate, D::Error> {
    read(d, "degrees per second above 0, at most 1000", |x| x > 0.0 && x <= RATE_MAX_DEG_PER_S)
        .map(AngularRate::from_deg_per_s)
}

/// Degrees per second squared above zero.
pub(super) fn angular_acceleration<'de, D: Deserializer<'de>>(
    d: D,
) -> Result<AngularAcceleration, D::Error> {
    read(d, "degrees per second squared above 0, at most 10000", |x| {
        x > 0.0 && x <= ANGULAR_ACCELERATION_MAX_DEG_PER_S2
    })
    .map(AngularAcceleration::from_deg_per_s2)
}

/// Metres of a straight line, not zero.
pub(super) fn distance<'de, D: Deserializer<'de>>(d: D) -> Result<Length, D::Error> {
    read(d, "metres, not 0, at most 1000 either way", |x| x != 0.0 && x.abs() <= DISTANCE_MAX_M)
        .map(Length::from_m)
}

/// Metres above zero.
pub(super) fn length<'de, D: Deserializer<'de>>(d: D) -> Result<Length, D::Error> {
    read(d, "metres above 0, at most 1000", |x| x > 0.0 && x <= DISTANCE_MAX_M).map(Length::from_m)
}

/// Metres of a coordinate.
pub(super) fn coordinate<'de, D: Deserializer<'de>>(d: D) -> Result<Length, D::Error> {
    read(d, "metres, at most 1000 either way", |x| x.abs() <= DISTANCE_MAX_M).map(Length::from_m)
}

/// Metres per second above zero.
pub(super) fn speed<'de, D: Deserializer<'de>>(d: D) -> Result<Speed, D::Error> {
    read(d, "metres per second above 0, at most 10", |x| x > 0.0 && x <= SPEED_MAX_M_PER_S)
        .map(Speed::from_m_per_s)
}

/// Metres per second squared above zero.
fn acceleration<'de, D: Deserializer<'de>>(d: D) -> Result<Acceleration, D::Error> {
    read(d, "metres per second squared above 0, at most 100", |x| {
        x > 0.0 && x <= ACCELERATION_MAX_M_PER_S2
    })
    .map(Acceleration::from_m_per_s2)
}

/// Degrees above zero.
fn angle<'de, D: Deserializer<'de>>(d: D) -> Result<Angle, D::Error> {
    read(d, "degrees above 0, at most 360", |x| x > 0.0 && x <= 360.0).map(Angle::from_deg)
}

/// Metres per second squared above zero, or none.
pub(super) fn acceleration_option<'de, D: Deserializer<'de>>(
    d: D,
) -> Result<Option<Acceleration>, D::Error> {
    acceleration(d).map(Some)
}

/// Degrees per second squared above zero, or none.
pub(super) fn angular_acceleration_option<'de, D: Deserializer<'de>>(
    d: D,
) -> Result<Option<AngularAcceleration>, D::Error> {
    angular_acceleration(d).map(Some)
}

/// Metres per second above zero, or none.
pub(super) fn speed_option<'de, D: Deserializer<'de>>(d: D) -> Result<Option<Speed>, D::Error> {
    speed(d).map(Some)
}

/// Degrees per second above zero, or none.
pub(super) fn rate_option<'de, D: Deserializer<'de>>(
    d: D,
) -> Result<Option<AngularRate>, D::Error> {
    rate(d).map(Some)
}

/// Degrees above zero, or none.
pub(super) fn angle_option<'de, D: Deserializer<'de>>(d: D) -> Result<Option<Angle>, D::Error> {
    angle(d).map(Some)
}

/// Metres above zero, or none.
pub(super) fn length_option<'de, D: Deserializer<'de>>(d: D) -> Result<Option<Length>, D::Error> {
    length(d).map(Some)
}
