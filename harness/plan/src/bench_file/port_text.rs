//! A port in a bench file: a scheme and an address, `can:vcan0` or `serial:/dev/ttyUSB0`.
//!
//! Without the feature `ports` only the scheme is checked, and that an address is present if required. With it, the
//! whole text must be a `port::PortSpec` including options.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, de};
use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

wire::words! {
    /// The medium that carries bytes or frames, in the order in which they are suggested, by the schemes before the colon.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Medium {
        /// A serial port.
        Serial = "serial",
        /// A SocketCAN interface.
        Can = "can",
        /// A CAN adapter with the Lawicel ASCII protocol on a serial port.
        Slcan = "slcan",
        /// A pty pair that the harness creates.
        Pty = "pty",
        /// A pty pair on which the harness emulates such an adapter.
        SlcanPty = "slcan-pty",
    }
}

impl Medium {
    /// Whether it carries bytes instead of frames.
    pub const fn is_serial_line(self) -> bool {
        matches!(self, Self::Pty | Self::Serial)
    }

    /// Whether the harness creates it: nothing else is at its other end.
    pub const fn is_made_here(self) -> bool {
        matches!(self, Self::Pty | Self::SlcanPty)
    }
}

/// A port in a bench file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PortText {
    text: String,
    medium: Medium,
}

/// Why a text is not a port.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PortTextError {
    /// The scheme is unknown.
    #[error("unknown scheme `{0}`, expected one of `serial`, `can`, `slcan`, `pty`, `slcan-pty`")]
    Scheme(String),
    /// Neither a scheme nor a path.
    #[error(
        "\"{0}\" is no port, expected a path such as /dev/ttyUSB0 or a scheme such as can:can0"
    )]
    NoScheme(String),
    /// The scheme requires an address.
    #[error("the port \"{0}\" names no device, expected one after the colon")]
    NoAddress(String),
    /// The text after the scheme is invalid.
    #[error("{wrong}; {allowed}")]
    Rest {
        /// The error, including the port.
        wrong: String,
        /// The permitted values.
        allowed: String,
    },
}

impl PortText {
    /// The medium of its bytes or frames.
    pub const fn medium(&self) -> Medium {
        self.medium
    }

    /// The text of the port.
    pub fn as_str(&self) -> &str {
        &self.text
    }

    /// The path, interface or USB id after the scheme, without options; empty for a pty without a link.
    pub fn address(&self) -> &str {
        let after = match self.text.split_once(':') {
            _ if self.text.starts_with('/') => self.text.as_str(),
            Some((_, after)) => after,
            None => "",
        };
        after.split_once('?').map_or(after, |(address, _)| address)
    }
}

impl JsonSchema for PortText {
    fn schema_name() -> Cow<'static, str> {
        "Port".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let schemes = Medium::NAMES.join("|");
        json_schema!({
            "description": "A port: a path such as `/dev/ttyUSB0`, or a scheme such as `can:can0`, \
                `slcan:/dev/ttyACM0`, `serial:...`, `pty`, `slcan-pty`.",
            "type": "string",
            "pattern": format!("^(/|({schemes})(:|\\?|$))")
        })
    }
}

impl FromStr for PortText {
    type Err = PortTextError;

    fn from_str(text: &str) -> Result<Self, PortTextError> {
        let medium = match text.split_once(':') {
            _ if text.starts_with('/') => Medium::Serial,
            Some((scheme, _)) => find(scheme)?,
            None => match find(text.split('?').next().unwrap_or_default()) {
                Ok(medium) => medium,
                Err(_) => return Err(PortTextError::NoScheme(text.to_owned())),
            },
        };
        let port = Self { text: text.to_owned(), medium };
        if port.address().is_empty() && !medium.is_made_here() {
            return Err(PortTextError::NoAddress(port.text));
        }
        #[cfg(feature = "ports")]
        whole(&port.text)?;
        Ok(port)
    }
}

/// Checks that the port could be opened under this name.
#[cfg(feature = "ports")]
fn whole(text: &str) -> Result<(), PortTextError> {
    use miette::Diagnostic as _;
    let error = match text.parse::<ports::PortSpec>() {
        Ok(_) => return Ok(()),
        Err(error) => error,
    };
    let allowed = error.help().map(|help| help.to_string()).unwrap_or_default();
    Err(PortTextError::Rest { wrong: error.to_string(), allowed })
}

fn find(scheme: &str) -> Result<Medium, PortTextError> {
    let known = Medium::ALL.into_iter().find(|medium| medium.name() == scheme);
    known.ok_or_else(|| PortTextError::Scheme(scheme.to_owned()))
}

impl fmt::Display for PortText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl<'de> Deserialize<'de> for PortText {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::{Medium, PortText, PortTextError};
    use proptest::prelude::*;

    #[test]
    fn a_scheme_and_an_address() {
        for (text, medium, address) in [
            ("/dev/ttyUSB0", Medium::Serial, "/dev/ttyUSB0"),
            (
                "/dev/serial/by-id/usb-FTDI:x-if00",
                Medium::Serial,
                "/dev/serial/by-id/usb-FTDI:x-if00",
            ),
            ("serial:/dev/ttyUSB0?baud=9600", Medium::Serial, "/dev/ttyUSB0"),
            ("serial:usb:0403:6001", Medium::Serial, "usb:0403:6001"),
            ("can:vcan0", Medium::Can, "vcan0"),
            ("slcan:/dev/ttyACM0?bitrate=500000", Medium::Slcan, "/dev/ttyACM0"),
            ("pty", Medium::Pty, ""),
            ("pty:./gyro.pty", Medium::Pty, "./gyro.pty"),
            ("slcan-pty", Medium::SlcanPty, ""),
        ] {
            let port: PortText = text.parse().unwrap();
            assert_eq!((port.medium(), port.address(), port.as_str()), (medium, address, text));
        }
    }

    #[test]
    fn what_names_no_port_says_why() {
        let refused = |text: &str| text.parse::<PortText>().unwrap_err();
        assert_eq!(refused("cna:vcan0"), PortTextError::Scheme("cna".to_owned()));
        assert_eq!(refused("ttyUSB0"), PortTextError::NoScheme("ttyUSB0".to_owned()));
        assert_eq!(refused(""), PortTextError::NoScheme(String::new()));
        assert_eq!(refused("can:"), PortTextError::NoAddress("can:".to_owned()));
        assert_eq!(
            refused("serial:?baud=1"),
            PortTextError::NoAddress("serial:?baud=1".to_owned())
        );
        assert_eq!(refused("can"), PortTextError::NoAddress("can".to_owned()));
    }

    proptest! {
        #[test]
        fn whatever_is_taken_is_given_back(text in "[a-z:/?=é-]{0,24}") {
            if let Ok(port) = text.parse::<PortText>() {
                prop_assert_eq!(port.to_string(), text);
            }
        }
    }
}
