//! A value of a signal as people write it: a number, or the name that the DBC gives to it (`VAL_`).

use schemars::JsonSchema;
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

wire::either! { SignalValue, "a finite number or the name of a value",
    finite(value) => Ok(SignalValue::Number(value)),
    text(name) => Ok(SignalValue::Named(name.to_owned())),
}
