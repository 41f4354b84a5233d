//! Names in a plan: of plans, calibrations, fits, and of the parameters of devices.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{self, Unexpected};
use serde::{Deserialize, Deserializer, Serialize};
use std::borrow::Cow;
use std::fmt;

/// Longest [`Name`], in bytes.
pub const NAME_LEN_MAX: usize = 64;

/// What a [`Name`] is.
pub(super) const EXPECTED_NAME: &str =
    "a name of a-z, 0-9, `-` and `_`, at most 64 long, that begins with a letter";
const EXPECTED_PARAMETER: &str = "a parameter as `device.name`, for example `gyro.ambient_celsius`";

/// A name that is also a safe file name: a letter, then `a-z`, `0-9`, `-`, `_`.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Name(String);

impl Name {
    /// `None` if `text` is not a name.
    pub fn new(text: &str) -> Option<Self> {
        let rest = |b: u8| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-' || b == b'_';
        (text.len() <= NAME_LEN_MAX
            && text.bytes().next().is_some_and(|first| first.is_ascii_lowercase())
            && text.bytes().all(rest))
        .then(|| Self(text.to_owned()))
    }

    /// The syntax of names, as a regular expression.
    pub(super) fn pattern() -> String {
        format!("[a-z][a-z0-9_-]{{0,{}}}", NAME_LEN_MAX - 1)
    }

    /// The name.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl JsonSchema for Name {
    fn schema_name() -> Cow<'static, str> {
        "Name".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let pattern = format!("^{}$", Self::pattern());
        json_schema!({ "type": "string", "description": EXPECTED_NAME, "pattern": pattern })
    }
}

impl<'de> Deserialize<'de> for Name {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        Self::new(&text)
            .ok_or_else(|| de::Error::invalid_value(Unexpected::Str(&text), &EXPECTED_NAME))
    }
}

/// A parameter of a device or of the environment, written `device.name`. The world that runs the plan knows the valid
/// parameters; on a real bench the operator is asked to set them.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct ParameterName {
    /// The device: a role of the bench, such as `gyro`, or `room`.
    pub device: Name,
    /// The parameter; its name ends with its unit.
    pub parameter: Name,
}

impl ParameterName {
    /// `None` if `text` does not have the form `device.name`.
    pub fn new(text: &str) -> Option<Self> {
        let (device, parameter) = text.split_once('.')?;
        Some(Self { device: Name::new(device)?, parameter: Name::new(parameter)? })
    }
}

impl fmt::Display for ParameterName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.device, self.parameter)
    }
}

impl JsonSchema for ParameterName {
    fn schema_name() -> Cow<'static, str> {
        "ParameterName".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let name = Name::pattern();
        let pattern = format!(r"^{name}\.{name}$");
        json_schema!({ "type": "string", "description": EXPECTED_PARAMETER, "pattern": pattern })
    }
}

impl<'de> Deserialize<'de> for ParameterName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        Self::new(&text)
            .ok_or_else(|| de::Error::invalid_value(Unexpected::Str(&text), &EXPECTED_PARAMETER))
    }
}

#[cfg(test)]
mod tests {
    use super::{Name, ParameterName};

    #[test]
    fn a_name_is_a_safe_file_name() {
        for good in ["a", "table_error_cw", "verification-2"] {
            assert!(Name::new(good).is_some(), "{good}");
        }
        let long = "a".repeat(65);
        for bad in ["", "A", "2a", "../a", "a.b", "a/b", "-a", "ä", long.as_str()] {
            assert!(Name::new(bad).is_none(), "{bad}");
        }
    }

    #[test]
    fn a_parameter_names_its_device() {
        let name = ParameterName::new("gyro.ambient_celsius").unwrap();
        assert_eq!(name.to_string(), "gyro.ambient_celsius");
        for bad in ["gyro", "gyro.", ".x", "gyro.a.b"] {
            assert!(ParameterName::new(bad).is_none(), "{bad}");
        }
    }
}
