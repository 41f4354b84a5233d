//! The device under test of a bench.

use super::attach::AttachPlace;
use super::command;
use super::role::Yes;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{self, DeserializeSeed, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::borrow::Cow;
use std::fmt;

/// The kind of device under test.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ControllerSection {
    /// `in_process = true`: the built-in controller, in the process of the harness.
    InProcess,
    /// `command = [...]`: a program that the harness starts; `{gyro}` and `{base}` stand for the ports.
    Command(Vec<String>),
    /// `attach = "unix:/path.sock"`: a controller that is already running or started by hand, and takes its missions at
    /// this place.
    Attach(AttachPlace),
}

const KEYS: [&str; 3] = ["in_process", "command", "attach"];

/// The key; a second one is rejected here, so that the message points at it.
struct Key<'a>(Option<&'a str>);

impl<'de> DeserializeSeed<'de> for Key<'_> {
    type Value = &'static str;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<&'static str, D::Error> {
        let key = String::deserialize(deserializer)?;
        let known = KEYS.iter().find(|known| **known == key);
        let key = known.ok_or_else(|| de::Error::unknown_field(&key, &KEYS))?;
        match self.0 {
            None => Ok(key),
            Some(first) => Err(de::Error::custom(format_args!(
                "`{key}` beside `{first}`, expected one device under test"
            ))),
        }
    }
}

struct Words(Vec<String>);

impl<'de> Deserialize<'de> for Words {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        command::words(deserializer).map(Self)
    }
}

struct SectionVisitor;

impl<'de> Visitor<'de> for SectionVisitor {
    type Value = ControllerSection;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "a device under test: `in_process = true`, `command = [...]` or `attach = \"...\"`",
        )
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<ControllerSection, A::Error> {
        let mut section = None;
        let mut first = None;
        while let Some(key) = map.next_key_seed(Key(first))? {
            first = Some(key);
            section = Some(match key {
                "command" => ControllerSection::Command(map.next_value::<Words>()?.0),
                "attach" => ControllerSection::Attach(map.next_value()?),
                _ => map.next_value::<Yes>().map(|Yes| ControllerSection::InProcess)?,
            });
        }
        section.ok_or_else(|| {
            de::Error::custom(
                "no device under test, expected `in_process = true`, `command = [...]` or \
                 `attach = \"...\"`",
            )
        })
    }
}

impl JsonSchema for ControllerSection {
    fn schema_name() -> Cow<'static, str> {
        "Controller".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "The device under test: one of `in_process`, `command` and `attach`.",
            "type": "object",
            "properties": {
                "in_process": {
                    "description": "The controller that the harness brings along.",
                    "const": true
                },
                "command": {
                    "description": "A program that the harness starts; `{gyro}` and `{base}` stand for the ports.",
                    "type": "array",
                    "items": { "type": "string" },
                    "minItems": 1
                },
                "attach": {
                    "description": "Where one that runs already takes its missions: `unix:PATH`, `tcp:HOST:PORT` or a serial port.",
                    "type": "string"
                }
            },
            "minProperties": 1,
            "maxProperties": 1,
            "additionalProperties": false
        })
    }
}

impl<'de> Deserialize<'de> for ControllerSection {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(SectionVisitor)
    }
}
