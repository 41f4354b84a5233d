//! The device in a role: at a port, or emulated.

use super::port_text::PortText;
use schemars::{Schema, SchemaGenerator, json_schema};
use serde::de::{self, Unexpected};
use serde::{Deserialize, Deserializer};

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

pub(super) fn anywhere<'de, D: Deserializer<'de>>(d: D) -> Result<Option<Role>, D::Error> {
    read::<PortText, D>(d)
}

/// A role that requires a serial line.
pub(super) fn on_a_serial_line<'de, D: Deserializer<'de>>(d: D) -> Result<Option<Role>, D::Error> {
    read::<SerialText, D>(d)
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
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Yes;

impl<'de> Deserialize<'de> for Yes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        if bool::deserialize(deserializer)? {
            return Ok(Self);
        }
        Err(de::Error::invalid_value(Unexpected::Bool(false), &"`true`, or no such key"))
    }
}

pub(super) fn schema(generator: &mut SchemaGenerator) -> Schema {
    let port = generator.subschema_for::<PortText>();
    let port_doc = "Where the device is, or where an emulated one is put.";
    let emulated_doc = "An emulated device plays the role.";
    json_schema!({
        "type": "object",
        "properties": {
            "port": { "description": port_doc, "anyOf": [port] },
            "emulated": { "description": emulated_doc, "const": true }
        },
        "minProperties": 1,
        "additionalProperties": false
    })
}

/// A role as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a role with `port = \"...\"`, `emulated = true` or both")]
struct Written<P> {
    port: Option<P>,
    emulated: Option<Yes>,
}

fn read<'de, P, D>(deserializer: D) -> Result<Option<Role>, D::Error>
where
    P: Deserialize<'de> + Into<PortText>,
    D: Deserializer<'de>,
{
    let Written::<P> { port, emulated } = Written::deserialize(deserializer)?;
    match (port.map(P::into), emulated) {
        (port, Some(Yes)) => Ok(Some(Role::Emulated(port))),
        (Some(port), None) if port.medium().is_made_here() => Err(de::Error::custom(format_args!(
            "nothing is behind the port \"{port}\", expected `emulated = true` beside it"
        ))),
        (Some(port), None) => Ok(Some(Role::Real(port))),
        (None, None) => Err(de::Error::custom(
            "a role without a player, expected `port = \"...\"`, `emulated = true` or both",
        )),
    }
}
