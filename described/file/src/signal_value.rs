//! A value of a signal as people write it: a number, or the name that the DBC gives to it (`VAL_`).

use schemars::JsonSchema;
use serde::de::{Deserialize, Deserializer, Error, Unexpected, Visitor};
use std::fmt;

/// A number in the signal's unit, or the name of a value.
#[derive(Debug, Clone, PartialEq, JsonSchema)]
#[schemars(untagged)]
pub enum SignalValue {
    /// In the unit of the signal.
    Number(f64),
    /// The name of a value in the file of the layout.
    Named(String),
}

impl From<f64> for SignalValue {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl fmt::Display for SignalValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => number.fmt(f),
            Self::Named(name) => f.write_str(name),
        }
    }
}

impl<'de> Deserialize<'de> for SignalValue {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Written;
        impl Visitor<'_> for Written {
            type Value = SignalValue;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a finite number or the name of a value")
            }

            fn visit_f64<E: Error>(self, value: f64) -> Result<SignalValue, E> {
                match value.is_finite() {
                    true => Ok(SignalValue::Number(value)),
                    false => Err(E::invalid_value(Unexpected::Float(value), &self)),
                }
            }

            fn visit_i64<E: Error>(self, value: i64) -> Result<SignalValue, E> {
                Ok(SignalValue::Number(value as f64))
            }

            fn visit_u64<E: Error>(self, value: u64) -> Result<SignalValue, E> {
                Ok(SignalValue::Number(value as f64))
            }

            fn visit_str<E: Error>(self, value: &str) -> Result<SignalValue, E> {
                Ok(SignalValue::Named(value.to_owned()))
            }
        }
        deserializer.deserialize_any(Written)
    }
}
