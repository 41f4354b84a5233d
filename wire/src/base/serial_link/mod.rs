//! The command set on a serial line: the exchange of a Cybermotion-style blackboard.
//!
//! Source: J. M. Holland (founder of Cybermotion), *Designing Autonomous Mobile Robots*, Newnes 2004,
//! chapter 6, Figs 6.3 and 6.4, which give the two message forms and these two lines:
//!
//! | | line, ended by CR | answer, binary |
//! |---|---|---|
//! | write | `:` nn aaaa dd data cks, as in `:031F0001010203D7` | cks |
//! | read | `;` nn aaaa ss cks, as in `;05E000011A` | nn bytes of data, checksum |
//!
//! Each byte of a line is two hexadecimal digits: nn counts the data bytes, aaaa is the address of the first, dd or ss
//! the computer that holds them. cks makes the sum of all bytes of the line zero modulo 256. A read's checksum covers
//! data *and request*, taken here as the bytes nn aaaa ss without cks, since with cks a request would add nothing
//! (assumption).
//!
//! The answer to a write means *received*; see [`super`] for the result of a pose write. A line that is not understood
//! (checksum, unknown register, wrong count) gets no answer: the host notices by its time-out and repeats the line, as
//! in the source.
//!
//! * [`Host`] encodes request lines and decodes answers, one exchange at a time.
//! * [`Device`] decodes request lines and encodes answers.
//! * [`Line`] and [`LineDecoder`] are the lines themselves, for any register.
//!
//! A write of a velocity and a read of the motion are 20 + 1 + 12 + 9 characters: 22 ms at 19200 baud,
//! within the 27 ms of the original's host loop.

mod device;
mod host;
mod line;

pub use device::{Device, DeviceCounters, DeviceEvent, ReadAnswer, Refusal, write_answer};
pub use host::{Host, HostCounters, HostEvent};
pub use line::{Line, LineDecoder, LineError};

use super::payload::PAYLOAD_BYTES_MAX;
use crate::serial::SerialSettings;
use crate::time::Span;

/// The line's settings: 19200 8N1 (rate [published](self); framing an assumption).
pub const SETTINGS: SerialSettings = SerialSettings::new_8n1(19_200);

/// The base's computer id in the published lines.
pub const COMPUTER_ID: u8 = 0x01;

/// Maximum number of bytes that a line encodes: nn, aaaa, dd, data, cks.
const FIELD_BYTES_MAX: usize = 1 + 2 + 1 + PAYLOAD_BYTES_MAX + 1;

/// The longest line, in characters: its first character, two for each byte, CR.
pub const LINE_BYTES_MAX: usize = 1 + 2 * FIELD_BYTES_MAX + 1;

/// The longest answer to a request of this command set: eight bytes and a checksum.
pub const ANSWER_BYTES_MAX: usize = PAYLOAD_BYTES_MAX + 1;

/// [`Device`] and [`LineDecoder`] understand the first good line after any garbage: `:` and `;` restart a line at any
/// position. That line ends within this many bytes after the garbage.
pub const RESYNC_BYTES_MAX: usize = LINE_BYTES_MAX;

/// Time that a host waits after a bad checksum or an abandoned exchange: meanwhile a late or overlong answer passes as
/// [`HostEvent::Unexpected`] and cannot be taken for part of the next one.
pub fn quiet_time() -> Span {
    SETTINGS.time_for(ANSWER_BYTES_MAX)
}

/// The byte that makes the sum of `bytes` and itself zero modulo 256.
fn checksum(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0, |rest, byte| rest.wrapping_sub(*byte))
}

/// The last byte of a read's answer: the checksum over the data and the request, given the request's own checksum.
fn answer_checksum(request_checksum: u8, data: &[u8]) -> u8 {
    // The request's checksum is minus the sum of its other bytes.
    request_checksum.wrapping_add(checksum(data))
}

#[cfg(test)]
mod tests;
