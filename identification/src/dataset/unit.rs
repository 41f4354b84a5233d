//! Units of measured data as data packages name them, and their SI values.

use serde::{Deserialize, Serialize};
use std::fmt;

macro_rules! units {
    ($($(#[doc = $doc:literal])+ $variant:ident = $text:literal, $si:expr, $dimension:ident;)*) => {
        /// A unit of the contract. `Cel` stays in degrees Celsius; gauss, counts and sample numbers stay as they are.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        pub enum Unit {
            $($(#[doc = $doc])+ #[serde(rename = $text)] $variant,)*
        }

        impl Unit {
            /// Every unit.
            pub const ALL: &[Self] = &[$(Self::$variant),*];

            /// Text in a data package.
            pub const fn text(self) -> &'static str {
                match self { $(Self::$variant => $text,)* }
            }

            /// One of it in the SI unit of its dimension.
            pub const fn si(self) -> f64 {
                match self { $(Self::$variant => $si,)* }
            }

            /// Its dimension.
            pub const fn dimension(self) -> Dimension {
                match self { $(Self::$variant => Dimension::$dimension,)* }
            }
        }
    };
}

/// Dimension of a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Dimension {
    Time,
    Angle,
    AngularRate,
    Length,
    Speed,
    Acceleration,
    Temperature,
    Voltage,
    Current,
    MagneticField,
    Frequency,
    Count,
    Number,
}

impl Dimension {
    /// Whether its zero is where nothing is, and not where somebody put it: that of an angle, a position, a temperature in
    /// degrees Celsius or a time is a matter of choice.
    pub const fn has_own_zero(self) -> bool {
        !matches!(self, Self::Angle | Self::Length | Self::Temperature | Self::Time)
    }
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;

units! {
    /// Second.
    Second = "s", 1.0, Time;
    /// Degree.
    Degree = "deg", DEGREE, Angle;
    /// Radian.
    Radian = "rad", 1.0, Angle;
    /// Degree per second.
    DegreePerSecond = "deg/s", DEGREE, AngularRate;
    /// Radian per second.
    RadianPerSecond = "rad/s", 1.0, AngularRate;
    /// Degree per hour.
    DegreePerHour = "deg/h", DEGREE / 3600.0, AngularRate;
    /// Metre.
    Metre = "m", 1.0, Length;
    /// Metre per second.
    MetrePerSecond = "m/s", 1.0, Speed;
    /// Metre per second squared.
    MetrePerSecondSquared = "m/s2", 1.0, Acceleration;
    /// Degree Celsius.
    Celsius = "Cel", 1.0, Temperature;
    /// Volt.
    Volt = "V", 1.0, Voltage;
    /// Ampere.
    Ampere = "A", 1.0, Current;
    /// Gauss.
    Gauss = "G", 1.0, MagneticField;
    /// Hertz.
    Hertz = "Hz", 1.0, Frequency;
    /// A count of an encoder or converter.
    Count = "count", 1.0, Count;
    /// A plain number; as a time, a sample number.
    One = "1", 1.0, Number;
}

impl Unit {
    /// The unit with that text.
    pub fn parse(text: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|unit| unit.text() == text)
    }

    /// Text of its differences and rates: a temperature difference is in kelvin.
    pub const fn difference_text(self) -> &'static str {
        match self {
            Self::Celsius => "K",
            other => other.text(),
        }
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.text())
    }
}
