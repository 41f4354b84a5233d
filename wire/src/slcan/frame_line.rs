//! A frame as a line, identical in both directions.

use super::hex::{nibble, parse_hex, push_hex};
use super::{CR, LineError};
use crate::can::{CanFrame, DATA_BYTES_MAX, ExtendedId, FD_LENGTHS, Id, StandardId};
use crate::packet::Packet;
use embedded_can::Frame as _;

/// Digits of a standard and of an extended identifier.
const STANDARD_DIGITS: usize = 3;
const EXTENDED_DIGITS: usize = 8;
const TIMESTAMP_DIGITS: usize = 4;

/// A frame that an adapter received from its bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReceivedFrame {
    /// The frame.
    pub frame: CanFrame,
    /// Reception time, if the adapter reports it: milliseconds of its own clock, which usually wraps at
    /// [`TIMESTAMP_WRAP_MS`](super::TIMESTAMP_WRAP_MS).
    pub timestamp_ms: Option<u16>,
}

/// The frame's line, CR included.
pub(super) fn encode(frame: &CanFrame, timestamp_ms: Option<u16>) -> Packet {
    let mut packet = Packet::new();
    match (frame.id(), frame.is_remote()) {
        (Id::Standard(_), false) => packet.push(b't'),
        (Id::Standard(_), true) => packet.push(b'r'),
        (Id::Extended(_), false) => packet.push(b'T'),
        (Id::Extended(_), true) => packet.push(b'R'),
    };
    match frame.id() {
        Id::Standard(id) => push_hex(&mut packet, id.as_raw().into(), STANDARD_DIGITS as u32),
        Id::Extended(id) => push_hex(&mut packet, id.as_raw(), EXTENDED_DIGITS as u32),
    }
    push_hex(&mut packet, frame.dlc() as u32, 1);
    for byte in frame.data() {
        push_hex(&mut packet, (*byte).into(), 2);
    }
    if let Some(timestamp_ms) = timestamp_ms {
        push_hex(&mut packet, timestamp_ms.into(), TIMESTAMP_DIGITS as u32);
    }
    packet.push(CR);
    packet
}

/// Parses a line without its terminator, whose first letter is one of `t`, `T`, `r`, `R`.
pub(super) fn parse(line: &[u8]) -> Result<ReceivedFrame, LineError> {
    parse_classic(line).ok_or(LineError::Malformed)
}

fn parse_classic(line: &[u8]) -> Option<ReceivedFrame> {
    let (letter, rest) = line.split_first()?;
    let (id, rest): (Id, _) = if letter.is_ascii_lowercase() {
        let (digits, rest) = rest.split_at_checked(STANDARD_DIGITS)?;
        (StandardId::new(parse_hex(digits)? as u16)?.into(), rest)
    } else {
        let (digits, rest) = rest.split_at_checked(EXTENDED_DIGITS)?;
        (ExtendedId::new(parse_hex(digits)?)?.into(), rest)
    };
    let (length, rest) = rest.split_first()?;
    let length = usize::from(nibble(*length)?);
    if length > DATA_BYTES_MAX {
        return None;
    }
    let (frame, rest) = if matches!(letter, b'r' | b'R') {
        (CanFrame::new_remote(id, length)?, rest)
    } else {
        let (digits, rest) = rest.split_at_checked(2 * length)?;
        let mut data = [0; DATA_BYTES_MAX];
        for (byte, pair) in data.iter_mut().zip(digits.as_chunks::<2>().0) {
            *byte = nibble(pair[0])? << 4 | nibble(pair[1])?;
        }
        (CanFrame::new(id, &data[..length])?, rest)
    };
    let timestamp_ms = match rest.len() {
        0 => None,
        TIMESTAMP_DIGITS => Some(parse_hex(rest)? as u16),
        _ => return None,
    };
    Some(ReceivedFrame { frame, timestamp_ms })
}

/// True if a line of `length` bytes that begins with `head` is a CAN FD frame. Digits after the head are not checked,
/// since they are not used.
pub(super) fn is_fd(head: &[u8], length: usize) -> bool {
    let digits = match head.first() {
        Some(b'd' | b'b') => STANDARD_DIGITS,
        Some(b'D' | b'B') => EXTENDED_DIGITS,
        _ => return false,
    };
    let header = 1 + digits + 1;
    let Some(code) = head.get(header - 1).and_then(|code| nibble(*code)) else {
        return false;
    };
    let bytes = header + 2 * usize::from(FD_LENGTHS[usize::from(code)]);
    (length == bytes || length == bytes + TIMESTAMP_DIGITS)
        && head[1..].iter().all(u8::is_ascii_hexdigit)
}
