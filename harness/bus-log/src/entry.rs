//! One entry of a bus log, independent of the format.

use std::fmt;
use wire::can::CanFrame;
use wire::packet::Packet;
use wire::time::Timestamp;

/// Longest name of a channel: `IFNAMSIZ` minus the terminating zero (linux/if.h).
pub const CHANNEL_BYTES_MAX: usize = 15;

/// Something on a bus or a line, with time, place and direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// Time as in the log: since 1970 in a log of a bench, since the start in one of a run.
    pub at: Timestamp,
    pub channel: Channel,
    /// Seen from the logging node; `None` if the log does not say.
    pub direction: Option<Direction>,
    pub payload: Payload,
}

wire::tabled! {
    /// Direction, seen from the logging node, in the order of its numbers in logs.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Direction {
        /// The node received it.
        Rx = "Rx",
        /// The node sent it.
        Tx = "Tx",
    }
    /// Its word in logs.
    pub(super) fn word() -> &'static str
}

impl Direction {
    pub(super) fn of_word(word: &[u8]) -> Option<Self> {
        Self::ALL.into_iter().find(|direction| direction.word().as_bytes() == word)
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Payload {
    Frame(CanFrame),
    /// An error seen by the controller of the interface.
    Error(ErrorFrame),
    /// Bytes of a serial line that arrived together.
    Serial(Packet),
}

/// Name of a bus or a line, e.g. `can0`: like that of a network interface, without white space or control characters.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Channel {
    length: u8,
    bytes: [u8; CHANNEL_BYTES_MAX],
}

impl Channel {
    /// A channel of that name; `None` if the name is invalid.
    pub fn new(name: &str) -> Option<Self> {
        let fits = |c: char| !c.is_whitespace() && !c.is_control();
        let mut bytes = [0; CHANNEL_BYTES_MAX];
        bytes.get_mut(..name.len())?.copy_from_slice(name.as_bytes());
        let named = !name.is_empty() && name.chars().all(fits);
        named.then_some(Self { length: name.len() as u8, bytes })
    }

    /// A channel with a number and no name, as in an ASC file: `can` and the number.
    pub fn numbered(number: u32) -> Self {
        // `can` and the ten digits of the largest number take 13 bytes.
        Self::new(&format!("can{number}")).unwrap_or(Self::CAN0)
    }

    /// `can0`.
    pub const CAN0: Self = Self { length: 4, bytes: *b"can0\0\0\0\0\0\0\0\0\0\0\0" };

    pub fn as_str(&self) -> &str {
        std::str::from_utf8(self.as_bytes()).unwrap_or_default()
    }

    pub(super) fn as_bytes(&self) -> &[u8] {
        &self.bytes[..usize::from(self.length)]
    }
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl fmt::Debug for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.as_str().fmt(f)
    }
}

/// An error seen by the controller of a CAN interface, as in `linux/can/error.h`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ErrorFrame {
    class: u32,
    pub details: [u8; wire::can::DATA_BYTES_MAX],
}

/// `CAN_ERR_MASK`: the bits of an error class.
const CLASS_MASK: u32 = 0x1fff_ffff;

impl ErrorFrame {
    /// An error on the bus without details (`CAN_ERR_BUSERROR`).
    pub const BUS_ERROR: Self = Self { class: 0x80, details: [0; wire::can::DATA_BYTES_MAX] };

    /// An error of these classes, a combination of `CAN_ERR_*`; `None` beyond 29 bits.
    pub const fn new(class: u32, details: [u8; wire::can::DATA_BYTES_MAX]) -> Option<Self> {
        if class & !CLASS_MASK == 0 { Some(Self { class, details }) } else { None }
    }

    /// The classes: a combination of `CAN_ERR_*`.
    pub const fn class(&self) -> u32 {
        self.class
    }
}

#[cfg(test)]
mod tests {
    use super::{Channel, ErrorFrame};

    #[test]
    fn a_channel_is_named_as_an_interface() {
        assert_eq!(Channel::new("vcan0").unwrap().as_str(), "vcan0");
        assert_eq!(Channel::new("fifteen-letters").unwrap().to_string(), "fifteen-letters");
        for name in ["", "sixteen-letters-", "two words", "line\n", "\u{7f}"] {
            assert_eq!(Channel::new(name), None, "{name:?}");
        }
        assert_eq!(Channel::numbered(0), Channel::CAN0);
        assert_eq!(Channel::numbered(u32::MAX).as_str(), "can4294967295");
    }

    #[test]
    fn an_error_has_29_bits() {
        assert_eq!(ErrorFrame::new(0x2000_0000, [0; 8]), None);
    }
}
