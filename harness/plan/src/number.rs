//! Numbers of a plan file: checked against bounds during parsing, in SI units from then on.
//!
//! Each kind is the `with` of a serde field: a value out of bounds is rejected there, so that the error contains its place
//! in the file, and the JSON Schema of the field has the same bounds.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{self, Unexpected, Visitor};
use serde::{Deserializer, Serialize as _, Serializer};
use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;
use wire::time::Span;
use wire::units::{self, Acceleration, AngularRate, Length, Speed};

/// Longest duration in a plan: 31 days. Assumption: a longer one is an error of units.
pub const DURATION_MAX_S: f64 = 31.0 * 86_400.0;
/// Longest limit of a command of a bench, and longest wait for an attached controller. Assumption: the slowest flash
/// over a serial bootloader takes minutes, and a user who has not started a controller within an hour will not.
pub const COMMAND_S_MAX: f64 = 3_600.0;
/// Largest permitted lateness of a bench. Assumption: one that is later than the slowest measured motion, a lap's
/// corner of some 10 s, measures nothing.
const LATE_MS_MAX_MAX: f64 = 10_000.0;
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

/// Which finite numbers are allowed.
pub(crate) enum Bounds {
    Any,
    /// Above zero, up to this, which may be infinite.
    Above(f64),
    /// From zero up to this.
    FromZero(f64),
    /// Zero, or at least this and at most the other.
    ZeroOr(f64, f64),
    /// Either way up to this.
    EitherWay(f64),
    /// The same without zero.
    NotZero(f64),
}

impl Bounds {
    fn has(&self, x: f64) -> bool {
        match *self {
            Self::Any => true,
            Self::Above(most) => x > 0.0 && x <= most,
            Self::FromZero(most) => (0.0..=most).contains(&x),
            Self::ZeroOr(least, most) => x == 0.0 || (least..=most).contains(&x),
            Self::EitherWay(most) => x.abs() <= most,
            Self::NotZero(most) => x != 0.0 && x.abs() <= most,
        }
    }

    fn schema(&self) -> Schema {
        match *self {
            Self::Above(most) if most.is_finite() => {
                json_schema!({ "type": "number", "exclusiveMinimum": 0, "maximum": most })
            }
            Self::Any => json_schema!({ "type": "number" }),
            Self::Above(_) => json_schema!({ "type": "number", "exclusiveMinimum": 0 }),
            Self::FromZero(most) if most.is_finite() => {
                json_schema!({ "type": "number", "minimum": 0, "maximum": most })
            }
            Self::FromZero(_) => json_schema!({ "type": "number", "minimum": 0 }),
            Self::ZeroOr(least, most) => json_schema!({
                "type": "number", "anyOf": [{ "const": 0 }, { "minimum": least, "maximum": most }] }),
            Self::EitherWay(most) => {
                json_schema!({ "type": "number", "minimum": -most, "maximum": most })
            }
            Self::NotZero(most) => json_schema!({
                "type": "number", "minimum": -most, "maximum": most, "not": { "const": 0 } }),
        }
    }
}

/// What a number means: its bounds, as written, and its value in SI.
pub(crate) trait Kind {
    type Value: Copy;
    const BOUNDS: Bounds;
    /// What an error says was expected.
    const EXPECTED: &'static str;
    fn value(written: f64) -> Self::Value;
    fn written(value: Self::Value) -> f64;
}

/// A number of this kind, or none, as the `with` of a field.
pub(crate) struct Number<K>(PhantomData<K>);

impl<K: Kind> Number<K> {
    pub(crate) fn deserialize<'de, T, D>(deserializer: D) -> Result<T, D::Error>
    where
        T: From<K::Value>,
        D: Deserializer<'de>,
    {
        deserializer.deserialize_f64(Self(PhantomData)).map(|number| K::value(number).into())
    }

    /// As the file states it; schemas show defaults so.
    pub(crate) fn serialize<T, S>(value: &T, serializer: S) -> Result<S::Ok, S::Error>
    where
        T: Copy + Into<Option<K::Value>>,
        S: Serializer,
    {
        (*value).into().map(K::written).serialize(serializer)
    }
}

impl<K: Kind> Visitor<'_> for Number<K> {
    type Value = f64;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(K::EXPECTED)
    }

    fn visit_f64<E: de::Error>(self, value: f64) -> Result<f64, E> {
        within::<K, E>(value, Unexpected::Float(value))
    }

    fn visit_i64<E: de::Error>(self, value: i64) -> Result<f64, E> {
        within::<K, E>(value as f64, Unexpected::Signed(value))
    }
}

/// The number, if it is finite and within the bounds; `written` is the number as the file has it.
fn within<K: Kind, E: de::Error>(value: f64, written: Unexpected<'_>) -> Result<f64, E> {
    let is_right = value.is_finite() && K::BOUNDS.has(value);
    is_right.then_some(value).ok_or_else(|| E::invalid_value(written, &K::EXPECTED))
}

impl<K: Kind> JsonSchema for Number<K> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        K::EXPECTED.into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        K::BOUNDS.schema()
    }
}

/// Without the rounding errors of unit conversion: 30 deg/s is 29.999999999999996 after a conversion there and back.
fn tidy(value: f64) -> f64 {
    const PER_UNIT: f64 = 1e9;
    (value * PER_UNIT).round() / PER_UNIT
}

macro_rules! numbers {
    ($($name:ident: $value:ty = $bounds:expr, $expected:literal, $read:expr, $write:expr;)*) => {
        mod kind {
            $(pub(crate) struct $name;)*
        }

        $(
            #[doc = $expected]
            pub(crate) type $name = Number<kind::$name>;

            impl Kind for kind::$name {
                type Value = $value;
                const BOUNDS: Bounds = $bounds;
                const EXPECTED: &'static str = $expected;

                fn value(written: f64) -> $value {
                    $read(written)
                }

                fn written(value: $value) -> f64 {
                    $write(value)
                }
            }
        )*
    };
}

numbers! {
    Finite: f64 = Bounds::Any, "a finite number", f64::from, f64::from;
    Positive: f64 = Bounds::Above(f64::INFINITY), "a number above zero", f64::from, f64::from;
    NotNegative: f64 = Bounds::FromZero(f64::INFINITY), "0 or more", f64::from, f64::from;
    Share: f64 = Bounds::Above(1.0), "a share above 0 and at most 1", f64::from, f64::from;
    Duration: Span = Bounds::Above(DURATION_MAX_S), "a number of seconds above 0, at most 31 days",
        Span::from_secs_f64, Span::as_secs_f64;
    DurationOrZero: Span = Bounds::FromZero(DURATION_MAX_S), "a number of seconds, 0 to 31 days",
        Span::from_secs_f64, Span::as_secs_f64;
    SendingPeriod: Span = Bounds::ZeroOr(SENDING_PERIOD_MIN_S, DURATION_MAX_S),
        "0, or a number of seconds from 0.001 to 31 days", Span::from_secs_f64, Span::as_secs_f64;
    WithinHour: Span = Bounds::Above(COMMAND_S_MAX), "seconds above 0, at most 3600",
        Span::from_secs_f64, Span::as_secs_f64;
    Milliseconds: Span = Bounds::Above(LATE_MS_MAX_MAX), "milliseconds above 0, at most 10000",
        |ms: f64| Span::from_secs_f64(ms / 1e3), |span: Span| span.as_secs_f64() * 1e3;
    Turn: units::Angle = Bounds::NotZero(ANGLE_MAX_DEG),
        "degrees, not 0, at most 36000 either way", units::Angle::from_deg, degrees;
    Heading: units::Angle = Bounds::EitherWay(360.0), "a heading of -360 to 360 degrees",
        units::Angle::from_deg, degrees;
    Angle: units::Angle = Bounds::Above(360.0), "degrees above 0, at most 360",
        units::Angle::from_deg, degrees;
    Rate: AngularRate = Bounds::Above(RATE_MAX_DEG_PER_S),
        "degrees per second above 0, at most 1000",
        AngularRate::from_deg_per_s, |rate: AngularRate| tidy(rate.deg_per_s());
    AngularAcceleration: units::AngularAcceleration =
        Bounds::Above(ANGULAR_ACCELERATION_MAX_DEG_PER_S2),
        "degrees per second squared above 0, at most 10000",
        units::AngularAcceleration::from_deg_per_s2,
        |value: units::AngularAcceleration| tidy(value.deg_per_s2());
    Distance: Length = Bounds::NotZero(DISTANCE_MAX_M), "metres, not 0, at most 1000 either way",
        Length::from_m, Length::m;
    PathLength: Length = Bounds::Above(DISTANCE_MAX_M), "metres above 0, at most 1000",
        Length::from_m, Length::m;
    Coordinate: Length = Bounds::EitherWay(DISTANCE_MAX_M), "metres, at most 1000 either way",
        Length::from_m, Length::m;
    Steady: Speed = Bounds::Above(SPEED_MAX_M_PER_S), "metres per second above 0, at most 10",
        Speed::from_m_per_s, Speed::m_per_s;
    Ramp: Acceleration = Bounds::Above(ACCELERATION_MAX_M_PER_S2),
        "metres per second squared above 0, at most 100",
        Acceleration::from_m_per_s2, Acceleration::m_per_s2;
}

fn degrees(angle: units::Angle) -> f64 {
    tidy(angle.deg())
}
