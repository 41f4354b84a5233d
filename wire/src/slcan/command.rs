//! Commands of a host to an adapter.

use super::hex::{parse_hex, push_hex};
use super::{BitRate, BitTiming, CR, LineError, frame_line};
use crate::can::CanFrame;
use crate::packet::Packet;

/// Commands of a host to an adapter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Command {
    /// `S`: one of the usual bit rates.
    BitRate(BitRate),
    /// `s`: any other bit rate, by the controller's registers.
    BitTiming(BitTiming),
    /// `O`: join the bus.
    Open,
    /// `L`: receive from the bus and send nothing to it, not even acknowledgements.
    OpenListenOnly,
    /// `C`: leave the bus.
    Close,
    /// `V`: send the version.
    Version,
    /// `N`: send the serial number.
    SerialNumber,
    /// `F`: send the status flags and clear them.
    Status,
    /// `Z0`: send frames without a timestamp.
    TimestampsOff,
    /// `Z1`: send frames with a timestamp.
    TimestampsOn,
    /// `t`, `T`, `r`, `R`: send this frame.
    Transmit(CanFrame),
}

impl Command {
    /// The command's line, CR included.
    pub fn encode(&self) -> Packet {
        let mut packet = Packet::new();
        match self {
            Self::Transmit(frame) => return frame_line::encode(frame, None),
            Self::BitRate(rate) => packet.extend(&[b'S', rate.digit()]),
            Self::BitTiming(timing) => {
                packet.push(b's');
                push_hex(&mut packet, u16::from_be_bytes([timing.btr0, timing.btr1]).into(), 4);
                true
            }
            Self::Open => packet.push(b'O'),
            Self::OpenListenOnly => packet.push(b'L'),
            Self::Close => packet.push(b'C'),
            Self::Version => packet.push(b'V'),
            Self::SerialNumber => packet.push(b'N'),
            Self::Status => packet.push(b'F'),
            Self::TimestampsOff => packet.extend(b"Z0"),
            Self::TimestampsOn => packet.extend(b"Z1"),
        };
        packet.push(CR);
        packet
    }
}

/// Parses a line without its terminator.
pub fn parse_command(line: &[u8]) -> Result<Command, LineError> {
    Ok(match line {
        [b't' | b'T' | b'r' | b'R', ..] => {
            let received = frame_line::parse(line)?;
            if received.timestamp_ms.is_some() {
                return Err(LineError::Malformed);
            }
            Command::Transmit(received.frame)
        }
        [b'S', digit] => Command::BitRate(BitRate::from_digit(*digit).ok_or(LineError::Malformed)?),
        [b's', digits @ ..] if digits.len() == 4 => {
            let registers = parse_hex(digits).ok_or(LineError::Malformed)? as u16;
            let [btr0, btr1] = registers.to_be_bytes();
            Command::BitTiming(BitTiming { btr0, btr1 })
        }
        b"O" => Command::Open,
        b"L" => Command::OpenListenOnly,
        b"C" => Command::Close,
        b"V" => Command::Version,
        b"N" => Command::SerialNumber,
        b"F" => Command::Status,
        b"Z0" => Command::TimestampsOff,
        b"Z1" => Command::TimestampsOn,
        _ if frame_line::is_fd(line, line.len()) => return Err(LineError::Unsupported),
        _ => return Err(LineError::Malformed),
    })
}
