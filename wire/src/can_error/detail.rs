//! The detail bytes of an error frame, numbered as in `linux/can/error.h`.

use serde::{Deserialize, Serialize};

bitflags::bitflags! {
    /// The controller's buffers and error state (data byte 1).
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
    pub struct ControllerProblems: u8 {
        /// The receive buffer overflowed.
        const RX_OVERFLOW = 0x01;
        /// The transmit buffer overflowed.
        const TX_OVERFLOW = 0x02;
        /// The receive error counter reached 96.
        const RX_WARNING = 0x04;
        /// The transmit error counter reached 96.
        const TX_WARNING = 0x08;
        /// The receive error counter reached 128.
        const RX_PASSIVE = 0x10;
        /// The transmit error counter reached 128.
        const TX_PASSIVE = 0x20;
        /// The controller is error-active again.
        const ACTIVE = 0x40;
    }
}

bitflags::bitflags! {
    /// The violated rules (data byte 2); empty if unknown.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
    pub struct ProtocolErrors: u8 {
        /// A single bit was wrong.
        const BIT = 0x01;
        /// A bit of fixed form had the wrong value.
        const FORM = 0x02;
        /// Six equal bits where stuffing forbids them.
        const STUFF = 0x04;
        /// A dominant bit could not be sent.
        const BIT0 = 0x08;
        /// A recessive bit could not be sent.
        const BIT1 = 0x10;
        /// A node requested a pause.
        const OVERLOAD = 0x20;
        /// An active error was announced.
        const ACTIVE = 0x40;
        /// The error occurred while sending.
        const TX = 0x80;
    }
}

/// The violated rules and the place in the frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ProtocolViolation {
    /// The rules.
    pub errors: ProtocolErrors,
    /// The place in the frame.
    pub location: ProtocolLocation,
}

/// A place in a frame (data byte 3, numbered as in the SJA1000's error code capture); 0 if unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ProtocolLocation(pub u8);

impl ProtocolLocation {
    /// Unknown.
    pub const UNSPECIFIED: Self = Self(0x00);
    /// The checksum.
    pub const CRC_SEQUENCE: Self = Self(0x08);
    /// The acknowledgement slot.
    pub const ACKNOWLEDGEMENT_SLOT: Self = Self(0x19);

    /// Name of the place; `None` if unknown or unnamed.
    pub const fn name(self) -> Option<&'static str> {
        Some(match self.0 {
            0x02 => "identifier bits 28 to 21",
            0x03 => "start of frame",
            0x04 => "substitute remote request bit",
            0x05 => "identifier extension bit",
            0x06 => "identifier bits 20 to 18",
            0x07 => "identifier bits 17 to 13",
            0x08 => "checksum",
            0x09 => "reserved bit 0",
            0x0A => "data",
            0x0B => "data length code",
            0x0C => "remote request bit",
            0x0D => "reserved bit 1",
            0x0E => "identifier bits 4 to 0",
            0x0F => "identifier bits 12 to 5",
            0x12 => "intermission",
            0x18 => "checksum delimiter",
            0x19 => "acknowledgement slot",
            0x1A => "end of frame",
            0x1B => "acknowledgement delimiter",
            _ => return None,
        })
    }
}

/// Transceiver status of the wires (data byte 4): CANH in the low half, CANL in the high half; 0 if unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Transceiver(pub u8);

impl Transceiver {
    /// Describes the fault of CANH.
    pub const fn can_high(self) -> Option<&'static str> {
        fault(self.0 & 0x0F)
    }

    /// Describes the fault of CANL.
    pub const fn can_low(self) -> Option<&'static str> {
        match self.0 & 0xF0 {
            0x80 => Some("short circuit to CANH"),
            low => fault(low >> 4),
        }
    }
}

const fn fault(code: u8) -> Option<&'static str> {
    Some(match code {
        0x4 => "no wire",
        0x5 => "short circuit to the battery",
        0x6 => "short circuit to the supply",
        0x7 => "short circuit to ground",
        _ => return None,
    })
}
