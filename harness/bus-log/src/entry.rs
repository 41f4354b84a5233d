//! One entry of a bus log, whichever format it comes from or goes to.

use std::fmt;
use wire::can::CanFrame;
use wire::packet::Packet;
use wire::time::Timestamp;

/// The longest name of a channel: `IFNAMSIZ` less the closing zero (linux/if.h).
pub const CHANNEL_BYTES_MAX: usize = 15;

/// What was on a bus or a line, when, where and which way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// When, as the log has it: since 1970 in a log of a bench, since its begin in one of a run.
    pub at: Timestamp,
    /// On which bus or line.
    pub channel: Channel,
    /// Seen from the node that kept the log; none where the log does not say.
    pub direction: Option<Direction>,
    /// What it was.
    pub payload: Payload,
}

/// Which way, seen from the node that kept the log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// The node received it.
    Rx,
    /// The node sent it.
    Tx,
}

/// What an entry holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Payload {
    /// A frame, classic or FD.
    Frame(CanFrame),
    /// An error that the controller of the interface saw.
    Error(ErrorFrame),
    /// Bytes of a serial line that came together.
    Serial(Packet),
}

/// Name of a bus or a line, e.g. `can0`: as a network interface, without white space or control
/// characters.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Channel {
    length: u8,
    bytes: [u8; CHANNEL_BYTES_MAX],
}

impl Channel {
    /// A channel of that name; `None` where it cannot be one.
    pub fn new(name: &str) -> Option<Self> {
        let fits = |c: char| !c.is_whitespace() && !c.is_control();
        let mut bytes = [0; CHANNEL_BYTES_MAX];
        bytes.get_mut(..name.len())?.copy_from_slice(name.as_bytes());
        let named = !name.is_empty() && name.chars().all(fits);
        named.then_some(Self { length: name.len() as u8, bytes })
    }

    /// A channel that has a number and no name, as in an ASC file: `can` and the number.
    pub fn numbered(number: u32) -> Self {
        // `can` and the ten digits of the largest number are 13 bytes.
        Self::new(&format!("can{number}")).unwrap_or(Self::CAN0)
    }

    /// `can0`.
    pub const CAN0: Self = Self { length: 4, bytes: *b"can0\0\0\0\0\0\0\0\0\0\0\0" };

    /// The name.
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

/// An error that the controller of a CAN interface saw, as `linux/can/error.h` has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ErrorFrame {
    class: u32,
    /// What the driver knows of it.
    pub details: [u8; wire::can::DATA_BYTES_MAX],
}

/// `CAN_ERR_MASK`: the bits of an error's class.
const CLASS_MASK: u32 = 0x1fff_ffff;

impl ErrorFrame {
    /// An error on the bus of which no more is known (`CAN_ERR_BUSERROR`).
    pub const BUS_ERROR: Self = Self { class: 0x80, details: [0; wire::can::DATA_BYTES_MAX] };

    /// An error of these classes, an or of `CAN_ERR_*`; `None` where there are more than 29 bits.
    pub const fn new(class: u32, details: [u8; wire::can::DATA_BYTES_MAX]) -> Option<Self> {
        if class & !CLASS_MASK == 0 { Some(Self { class, details }) } else { None }
    }

    /// The classes: an or of `CAN_ERR_*`.
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
