//! One entry of a bus log, whichever format it comes from or goes to.

use std::fmt;
use wire::can::{CanFrame, Id};
use wire::packet::Packet;
use wire::time::Timestamp;

/// The longest name of a channel: `IFNAMSIZ` less the closing zero (linux/if.h).
pub const CHANNEL_BYTES_MAX: usize = 15;

/// The most data a CAN FD frame carries (`CANFD_MAX_DLEN`, linux/can.h).
pub const FD_BYTES_MAX: usize = 64;

/// Lengths of the data of a CAN FD frame, by its DLC (ISO 11898-1).
pub(super) const FD_LENGTHS: [u8; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64];

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
    /// A classic data frame or remote request.
    Frame(CanFrame),
    /// A CAN FD frame.
    Fd(FdFrame),
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

/// What a CAN FD frame says beside identifier and data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FdFlags {
    /// The data went at the faster rate (BRS).
    pub bit_rate_switch: bool,
    /// The sender is error-passive (ESI).
    pub error_state: bool,
}

/// `CANFD_BRS` and `CANFD_ESI` (linux/can.h).
const BRS: u8 = 0x01;
const ESI: u8 = 0x02;

impl FdFlags {
    /// From the flags of `struct canfd_frame`; others are not read.
    pub const fn from_bits(bits: u8) -> Self {
        Self { bit_rate_switch: bits & BRS != 0, error_state: bits & ESI != 0 }
    }

    /// As the flags of `struct canfd_frame`.
    pub const fn bits(self) -> u8 {
        (if self.bit_rate_switch { BRS } else { 0 }) | (if self.error_state { ESI } else { 0 })
    }
}

/// A CAN FD frame.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct FdFrame {
    id: Id,
    flags: FdFlags,
    length: u8,
    data: [u8; FD_BYTES_MAX],
}

impl FdFrame {
    /// A frame; `None` when no CAN FD frame has data of that length.
    pub fn new(id: impl Into<Id>, flags: FdFlags, data: &[u8]) -> Option<Self> {
        let length = *FD_LENGTHS.iter().find(|length| usize::from(**length) == data.len())?;
        let mut bytes = [0; FD_BYTES_MAX];
        bytes[..data.len()].copy_from_slice(data);
        Some(Self { id: id.into(), flags, length, data: bytes })
    }

    /// The identifier.
    pub const fn id(&self) -> Id {
        self.id
    }

    /// The flags.
    pub const fn flags(&self) -> FdFlags {
        self.flags
    }

    /// The data.
    pub fn data(&self) -> &[u8] {
        &self.data[..usize::from(self.length)]
    }

    /// The data length code.
    pub fn dlc(&self) -> u8 {
        let index = FD_LENGTHS.iter().position(|length| *length == self.length);
        index.map_or(0, |index| index as u8)
    }
}

impl fmt::Debug for FdFrame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { id, flags, .. } = self;
        write!(f, "FdFrame {{ {id:?}, {flags:?}, {:02x?} }}", self.data())
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
    use super::{Channel, ErrorFrame, FD_LENGTHS, FdFlags, FdFrame};
    use wire::can::StandardId;

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
    fn only_sixteen_lengths_are_fd() {
        let lengths: Vec<u8> = (0..=65)
            .filter(|length| {
                let data = vec![0; usize::from(*length)];
                FdFrame::new(StandardId::ZERO, FdFlags::default(), &data).is_some()
            })
            .collect();
        assert_eq!(lengths, FD_LENGTHS);
    }

    #[test]
    fn flags_come_back() {
        for bits in 0..4 {
            assert_eq!(FdFlags::from_bits(bits).bits(), bits);
        }
        assert_eq!(FdFlags::from_bits(0xfc), FdFlags::default());
        assert_eq!(ErrorFrame::new(0x2000_0000, [0; 8]), None);
    }
}
