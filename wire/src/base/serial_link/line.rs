//! Request lines, for any register: `:` writes, `;` reads.

use super::super::payload::Payload;
use super::{FIELD_BYTES_MAX, checksum};
use crate::packet::{BYTES_MAX, Packet};

const WRITE: u8 = b':';
const READ: u8 = b';';
const END: u8 = b'\r';
const DIGITS: &[u8; 16] = b"0123456789ABCDEF";

/// nn, aaaa and the computer id.
const HEADER_BYTES: usize = 4;

const _: () = assert!(super::LINE_BYTES_MAX <= BYTES_MAX, "a line fits a packet");

/// One request line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Line {
    /// Write `data` to `address`.
    Write {
        /// Address of the first byte.
        address: u16,
        /// The computer to write to.
        computer: u8,
        /// The data. No register of the command set takes more than eight bytes; a line with more is
        /// [`LineError::Malformed`].
        data: Payload,
    },
    /// Read from `address`.
    Read {
        /// Address of the first byte.
        address: u16,
        /// The computer to read from.
        computer: u8,
        /// Number of bytes.
        count: u8,
    },
}

impl Line {
    /// The line's characters, CR included.
    pub fn encode(&self) -> Packet {
        let mut packet = Packet::new();
        packet.push(match self {
            Self::Write { .. } => WRITE,
            Self::Read { .. } => READ,
        });
        let (header, data) = self.fields();
        for byte in header.iter().chain(data).chain(&[self.checksum()]) {
            packet.push(DIGITS[usize::from(byte >> 4)]);
            packet.push(DIGITS[usize::from(byte & 0x0F)]);
        }
        packet.push(END);
        packet
    }

    /// The line's checksum, which is also the answer to a write.
    pub fn checksum(&self) -> u8 {
        let (header, data) = self.fields();
        checksum(&header).wrapping_add(checksum(data))
    }

    fn fields(&self) -> ([u8; HEADER_BYTES], &[u8]) {
        let (count, address, computer, data) = match self {
            Self::Write { address, computer, data } => {
                (data.as_slice().len() as u8, address, *computer, data.as_slice())
            }
            Self::Read { address, computer, count } => (*count, address, *computer, &[][..]),
        };
        let [high, low] = address.to_be_bytes();
        ([count, high, low, computer], data)
    }
}

/// Reason why the characters between two line starts are not a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineError {
    /// Cut short, too long, a count that is not the number of data bytes, or not hexadecimal.
    Malformed,
    /// The sum of the bytes is not zero.
    BadChecksum,
}

#[derive(Debug, Clone, Copy)]
struct Partial {
    start: u8,
    fields: [u8; FIELD_BYTES_MAX],
    complete: usize,
    high_digit: Option<u8>,
}

impl Partial {
    const fn new(start: u8) -> Self {
        Self { start, fields: [0; FIELD_BYTES_MAX], complete: 0, high_digit: None }
    }

    /// Adds a digit; `None` if it is not a digit or the line is full.
    fn push(&mut self, character: u8) -> Option<()> {
        let digit = char::from(character).to_digit(16)? as u8;
        match self.high_digit.take() {
            None => self.high_digit = Some(digit),
            Some(high) => {
                *self.fields.get_mut(self.complete)? = high << 4 | digit;
                self.complete += 1;
            }
        }
        Some(())
    }

    fn finish(&self) -> Result<Line, LineError> {
        let bytes = self.fields.get(..self.complete).unwrap_or_default();
        let (&[count, high, low, computer], [data @ .., _]) =
            bytes.split_first_chunk::<HEADER_BYTES>().ok_or(LineError::Malformed)?
        else {
            return Err(LineError::Malformed);
        };
        let address = u16::from_be_bytes([high, low]);
        let line = match self.start {
            WRITE if data.len() == usize::from(count) => {
                Payload::from_slice(data).map(|data| Line::Write { address, computer, data })
            }
            READ if data.is_empty() => Some(Line::Read { address, computer, count }),
            _ => None,
        };
        match line {
            Some(line) if self.high_digit.is_none() => {
                if checksum(bytes) == 0 {
                    Ok(line)
                } else {
                    Err(LineError::BadChecksum)
                }
            }
            _ => Err(LineError::Malformed),
        }
    }
}

/// Finds request lines in a stream of characters.
///
/// `:` and `;` start a line at any position, so that nothing before them can corrupt it. Digits may be in either case.
/// Characters between lines are skipped and counted.
#[derive(Debug, Clone, Default)]
pub struct LineDecoder {
    partial: Option<Partial>,
    skipped: u64,
}

impl LineDecoder {
    /// Takes one character. Returns a line, or its error, at its CR, at the first character that does not belong in
    /// it, or at the start of the next line.
    pub fn push(&mut self, character: u8) -> Option<Result<Line, LineError>> {
        match (character, self.partial.as_mut()) {
            (WRITE | READ, _) => {
                let cut = self.partial.replace(Partial::new(character));
                cut.map(|_| Err(LineError::Malformed))
            }
            (END, Some(_)) => self.partial.take().map(|partial| partial.finish()),
            (_, Some(partial)) => match partial.push(character) {
                Some(()) => None,
                None => {
                    self.partial = None;
                    Some(Err(LineError::Malformed))
                }
            },
            (_, None) => {
                self.skipped += 1;
                None
            }
        }
    }

    /// Number of characters outside of lines.
    pub const fn skipped(&self) -> u64 {
        self.skipped
    }
}

#[cfg(test)]
mod tests;
