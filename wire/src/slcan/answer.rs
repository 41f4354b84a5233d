//! Lines from an adapter to its host.

use super::hex::{parse_hex, push_hex};
use super::{BEL, BusErrors, CR, LineError, ReceivedFrame, StateReport, Text, frame_line};
use crate::packet::Packet;

bitflags::bitflags! {
    /// The status flags, as `F` reads them (CANUSB manual; the names in brackets are those of the SJA1000).
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub struct StatusFlags: u8 {
        /// The queue of frames for the host was full, and frames were lost.
        const RECEIVE_FIFO_FULL = 1 << 0;
        /// The queue of frames for the bus was full, and frames were refused.
        const TRANSMIT_FIFO_FULL = 1 << 1;
        /// Error warning (EI): an error counter reached 96.
        const ERROR_WARNING = 1 << 2;
        /// Data overrun (DOI): the controller lost a frame.
        const DATA_OVERRUN = 1 << 3;
        /// Error-passive (EPI): an error counter reached 128.
        const ERROR_PASSIVE = 1 << 5;
        /// Arbitration lost (ALI).
        const ARBITRATION_LOST = 1 << 6;
        /// Bus error (BEI).
        const BUS_ERROR = 1 << 7;
    }
}

/// Lines from an adapter to its host, prompted or not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Answer {
    /// CR alone: the command was carried out. Some adapters acknowledge frames with it as well.
    Done,
    /// BEL: the command was not understood, or cannot be carried out at the moment.
    Refused,
    /// `z`: a frame with a standard identifier was accepted for sending.
    TakenStandard,
    /// `Z`: a frame with an extended identifier was accepted for sending.
    TakenExtended,
    /// `V`: the version.
    Version(Text),
    /// `N`: the serial number.
    SerialNumber(Text),
    /// `F`: the status flags.
    Status(StatusFlags),
    /// `t`, `T`, `r`, `R`: a frame from the bus.
    Frame(ReceivedFrame),
    /// `s`: the controller's state.
    State(StateReport),
    /// `e`: errors on the bus.
    Errors(BusErrors),
}

impl Answer {
    /// The bytes on the line, CR included.
    pub fn encode(&self) -> Packet {
        let mut packet = Packet::new();
        match self {
            Self::Refused => {
                packet.push(BEL);
                return packet;
            }
            Self::Frame(received) => {
                return frame_line::encode(&received.frame, received.timestamp_ms);
            }
            Self::Done => {}
            Self::TakenStandard => _ = packet.push(b'z'),
            Self::TakenExtended => _ = packet.push(b'Z'),
            Self::Version(text) => _ = packet.push(b'V') && packet.extend(text.as_bytes()),
            Self::SerialNumber(text) => _ = packet.push(b'N') && packet.extend(text.as_bytes()),
            Self::Status(flags) => {
                packet.push(b'F');
                push_hex(&mut packet, flags.bits().into(), 2);
            }
            Self::State(report) => report.push_to(&mut packet),
            Self::Errors(errors) => errors.push_to(&mut packet),
        }
        packet.push(CR);
        packet
    }
}

/// Parses a line without its CR; an empty line is [`Answer::Done`]. A BEL is not part of a line: it is
/// [`Answer::Refused`] by itself.
pub fn parse_answer(line: &[u8]) -> Result<Answer, LineError> {
    let answer = match line {
        [] => Some(Answer::Done),
        [b't' | b'T' | b'r' | b'R', ..] => return frame_line::parse(line).map(Answer::Frame),
        b"z" => Some(Answer::TakenStandard),
        b"Z" => Some(Answer::TakenExtended),
        [b'V', text @ ..] => Text::new(text).map(Answer::Version),
        [b'N', text @ ..] => Text::new(text).map(Answer::SerialNumber),
        [b'F', digits @ ..] if digits.len() == 2 => {
            parse_hex(digits).map(|bits| Answer::Status(StatusFlags::from_bits_retain(bits as u8)))
        }
        [b's', ..] => StateReport::parse(line).map(Answer::State),
        [b'e', ..] => BusErrors::parse(line).map(Answer::Errors),
        _ if frame_line::is_fd(line, line.len()) => return Err(LineError::Unsupported),
        _ => None,
    };
    answer.ok_or(LineError::Malformed)
}
