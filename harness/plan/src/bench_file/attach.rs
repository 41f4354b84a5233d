//! The connection to a controller that is already running.

use super::port_text::PortText;
use serde::de::Error;
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

/// Notation of a place, for messages.
const FORMS: &str = "\"unix:/path/of/a.sock\", \"tcp:HOST:PORT\", a serial port such as \
                     \"/dev/ttyUSB2\", or \"pty:./missions.pty\"";

/// The place where a running controller takes missions and sends reports: the JSON lines that a program has on stdin
/// and stdout, in both directions over one line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum AttachPlace {
    /// `unix:PATH`: a socket that the controller listens on.
    Unix(PathBuf),
    /// `tcp:HOST:PORT`: likewise. There is no encryption and no authentication.
    Tcp(String),
    /// A serial port with the controller at its other end, or a pty whose other end the controller opens.
    Line(PortText),
}

impl FromStr for AttachPlace {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = |wrong: String| format!("{wrong}, expected {FORMS}");
        match text.split_once(':') {
            Some(("unix", "")) => Err(expected("\"unix:\" names no socket".to_owned())),
            Some(("unix", path)) => Ok(Self::Unix(path.into())),
            Some(("tcp", address)) => match address.rsplit_once(':') {
                Some((host, port)) if !host.is_empty() && port.parse::<u16>().is_ok() => {
                    Ok(Self::Tcp(address.to_owned()))
                }
                _ => Err(expected(format!("\"{text}\" names no host and port"))),
            },
            _ => match text.parse::<PortText>() {
                Ok(port) if port.medium().is_serial_line() => Ok(Self::Line(port)),
                Ok(port) => Err(expected(format!("the port \"{port}\" carries frames"))),
                Err(error) => Err(expected(error.to_string())),
            },
        }
    }
}

impl fmt::Display for AttachPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unix(path) => write!(f, "unix:{}", path.display()),
            Self::Tcp(address) => write!(f, "tcp:{address}"),
            Self::Line(port) => port.fmt(f),
        }
    }
}

wire::either! { AttachPlace, FORMS,
    flag(_) => Err(Error::custom(format_args!(
        "nobody knows where the controller takes its missions, expected {FORMS}"
    ))),
    text(text) => text.parse().map_err(Error::custom),
}

#[cfg(test)]
mod tests {
    use super::AttachPlace;
    use proptest::prelude::*;

    #[test]
    fn a_place_is_a_socket_or_a_line() {
        for (text, socket) in [
            ("unix:./missions.sock", true),
            ("tcp:127.0.0.1:7000", true),
            ("tcp:[::1]:7000", true),
            ("/dev/ttyUSB2", false),
            ("serial:usb:0403:6001?baud=57600", false),
            ("pty:./missions.pty", false),
        ] {
            let place: AttachPlace = text.parse().unwrap();
            assert_eq!(!matches!(place, AttachPlace::Line(_)), socket, "{text}");
            assert_eq!(place.to_string(), text);
        }
    }

    #[test]
    fn what_is_no_place_says_what_would_be() {
        for text in ["", "unix:", "tcp:", "tcp::7000", "tcp:localhost", "tcp:x:70000", "can:can0"] {
            let why = text.parse::<AttachPlace>().unwrap_err();
            assert!(why.contains("expected \"unix:/path/of/a.sock\""), "{text}: {why}");
        }
    }

    proptest! {
        #[test]
        fn whatever_is_taken_is_given_back(text in "(unix:|tcp:|/)?[a-z0-9:/.?=é-]{0,24}") {
            if let Ok(place) = text.parse::<AttachPlace>() {
                prop_assert_eq!(place.to_string(), text);
            }
        }
    }
}
