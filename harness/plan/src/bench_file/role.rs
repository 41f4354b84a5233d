//! The device in a role: at a port, or emulated.

use super::port_text::PortText;
use schemars::{Schema, SchemaGenerator, json_schema};
use serde::de::{self, DeserializeSeed, MapAccess, Unexpected, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt;
use std::marker::PhantomData;

/// The device in a role.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Role {
    /// A real device, at this port.
    Real(PortText),
    /// An emulated device, at this port; without one the world chooses the place.
    Emulated(Option<PortText>),
}

impl Default for Role {
    fn default() -> Self {
        Self::Emulated(None)
    }
}

impl Role {
    /// Its port, if given.
    pub const fn port(&self) -> Option<&PortText> {
        match self {
            Self::Real(port) | Self::Emulated(Some(port)) => Some(port),
            Self::Emulated(None) => None,
        }
    }
}

/// A role that accepts any port.
pub(super) fn anywhere<'de, D: Deserializer<'de>>(d: D) -> Result<Option<Role>, D::Error> {
    d.deserialize_map(RoleVisitor::<PortText>(PhantomData)).map(Some)
}

/// A role that requires a serial line.
pub(super) fn on_a_serial_line<'de, D: Deserializer<'de>>(d: D) -> Result<Option<Role>, D::Error> {
    d.deserialize_map(RoleVisitor::<SerialText>(PhantomData)).map(Some)
}

/// A port that carries bytes.
struct SerialText(PortText);

impl From<SerialText> for PortText {
    fn from(port: SerialText) -> Self {
        port.0
    }
}

impl<'de> Deserialize<'de> for SerialText {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let port = PortText::deserialize(deserializer)?;
        if port.medium().is_serial_line() {
            return Ok(Self(port));
        }
        Err(de::Error::custom(format_args!(
            "the port \"{port}\" carries frames, expected a serial line: a path such as \
             /dev/ttyUSB0, `serial:...` or `pty`"
        )))
    }
}

/// Accepts only `true`; `false` would be a misunderstanding.
pub(super) struct Yes;

impl<'de> Deserialize<'de> for Yes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        if bool::deserialize(deserializer)? {
            return Ok(Self);
        }
        Err(de::Error::invalid_value(Unexpected::Bool(false), &"`true`, or no such key"))
    }
}

const PORT: &str = "port";
const EMULATED: &str = "emulated";

/// The key of a role.
struct Key;

impl<'de> DeserializeSeed<'de> for Key {
    type Value = &'static str;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<&'static str, D::Error> {
        match String::deserialize(deserializer)?.as_str() {
            PORT => Ok(PORT),
            EMULATED => Ok(EMULATED),
            other => Err(de::Error::unknown_field(other, &[PORT, EMULATED])),
        }
    }
}

/// The schema of a role, for editors.
pub(super) fn schema(generator: &mut SchemaGenerator) -> Schema {
    let port = generator.subschema_for::<PortText>();
    let port_doc = "Where the device is, or where an emulated one is put.";
    let emulated_doc = "An emulated device plays the role.";
    json_schema!({
        "type": "object",
        "properties": {
            PORT: { "description": port_doc, "anyOf": [port] },
            EMULATED: { "description": emulated_doc, "const": true }
        },
        "minProperties": 1,
        "additionalProperties": false
    })
}

struct RoleVisitor<P>(PhantomData<P>);

impl<'de, P: Deserialize<'de> + Into<PortText>> Visitor<'de> for RoleVisitor<P> {
    type Value = Role;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a role with `port = \"...\"`, `emulated = true` or both")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Role, A::Error> {
        let (mut port, mut emulated) = (None, None);
        while let Some(key) = map.next_key_seed(Key)? {
            match key {
                PORT => port = Some(map.next_value::<P>()?.into()),
                _ => emulated = Some(map.next_value::<Yes>()?),
            }
        }
        match (port, emulated) {
            (port, Some(Yes)) => Ok(Role::Emulated(port)),
            (Some(port), None) if port.medium().is_made_here() => {
                Err(de::Error::custom(format_args!(
                    "nothing is behind the port \"{port}\", expected `emulated = true` beside it"
                )))
            }
            (Some(port), None) => Ok(Role::Real(port)),
            (None, None) => Err(de::Error::custom(
                "a role without a player, expected `port = \"...\"`, `emulated = true` or both",
            )),
        }
    }
}
