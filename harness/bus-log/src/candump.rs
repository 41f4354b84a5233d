//! The log file of `candump -L`, as in can-utils `lib.h`: one frame per line.
//!
//! ```text
//! (1436509052.249713) vcan0 044#2A366C2BBA       data, identifier of 3 or 8 digits
//! (1436509052.449847) vcan0 12345678#R3 R        remote request for 3 bytes, received
//! (1436509052.650004) can1 123##1AABBCC T        CAN FD, flags 1, sent
//! (1436509052.850313) can1 20000004#0001000000000000    error frame: CAN_ERR_FLAG in the identifier
//! ```
//!
//! The direction mark comes from `candump -x` and may be missing. Fractions of up to nine digits are read; six are
//! written, as every version of can-utils takes six for microseconds. A raw DLC after a classic frame (`_9` to `_F`) is
//! dropped. CAN XL is refused.

use super::entry::{Channel, Direction, Entry, ErrorFrame, Payload};
use super::error::{Defect, LogError};
use super::hex;
use super::lines::Lines;
use super::{Format, Kept, ReadEntries, WriteEntries};
use embedded_can::Frame as _;
use std::fmt;
use std::io::{self, Read, Write};
use std::path::Path;
use wire::can::{self, CanFrame, DATA_BYTES_MAX, FD_BYTES_MAX, FdFlags, Id};
use wire::time::Timestamp;

/// `CAN_ERR_FLAG` of linux/can.h.
const ERROR_FLAG: u32 = 1 << 29;

const ON_SCREEN: &str =
    "this is what `candump` shows on the screen: record with `candump -L`, which writes a log";

/// The entries of a candump log.
#[derive(Debug)]
pub(crate) struct Reader<R: Read> {
    lines: Lines<R>,
    /// Channel of the previous line: usually also that of the next.
    channel: Channel,
}

impl<R: Read> Reader<R> {
    /// Reads from `input`; errors name `path`.
    pub(crate) fn new(path: &Path, input: R) -> Self {
        let lines = Lines::new(path, input, Format::Candump);
        Self { lines, channel: Channel::CAN0 }
    }
}

impl<R: Read + fmt::Debug> ReadEntries for Reader<R> {
    fn read(&mut self) -> Result<Option<Entry>, LogError> {
        while self.lines.advance()? {
            let text = self.lines.text();
            if !text.is_empty() {
                let entry = parse(text, self.channel).map_err(|defect| {
                    let defect = match is_on_screen(text) {
                        true => defect.advised(ON_SCREEN),
                        false => defect,
                    };
                    self.lines.malformed(defect)
                })?;
                self.channel = entry.channel;
                return Ok(Some(entry));
            }
        }
        Ok(None)
    }

    fn notes(&self) -> Vec<String> {
        self.lines.note().into_iter().collect()
    }
}

/// Parses a line that is not empty. `last` is the channel of the previous line.
fn parse(line: &[u8], last: Channel) -> Result<Entry, Defect> {
    let (time, rest) = hex::word(line);
    let at = time
        .strip_prefix(b"(")
        .and_then(|time| time.strip_suffix(b")"))
        .and_then(hex::seconds)
        .ok_or_else(|| Defect::new("a time such as `(1436509052.249713)`", time))?;
    let (name, rest) = hex::word(rest);
    let channel = if name == last.as_bytes() {
        last
    } else {
        let channel = std::str::from_utf8(name).ok().and_then(Channel::new);
        channel.ok_or_else(|| Defect::new("the name of an interface such as `can0`", name))?
    };
    let (frame, rest) = hex::word(rest);
    let payload = payload(frame)?;
    let (mark, rest) = hex::word(rest);
    let direction = match mark {
        b"" => None,
        b"R" => Some(Direction::Rx),
        b"T" => Some(Direction::Tx),
        other => return Err(Defect::new("`R` or `T` behind the frame", other)),
    };
    match rest {
        [] => Ok(Entry { at: Timestamp::from_nanos(at), channel, direction, payload }),
        more => Err(Defect::new("the end of the line", more)),
    }
}

/// Whether a line is one of `candump` without `-L`: a log has no length in brackets, as in `vcan0  123   [2]  11 22`.
fn is_on_screen(line: &[u8]) -> bool {
    let is_length = |word: &[u8]| match word {
        [b'[', digits @ .., b']'] => digits.iter().all(u8::is_ascii_digit),
        _ => false,
    };
    line.split(u8::is_ascii_whitespace).any(is_length)
}

fn payload(frame: &[u8]) -> Result<Payload, Defect> {
    let expected = || Defect::new("a frame such as `123#01FF`, `123#R` or `123##001FF`", frame);
    let end = frame.iter().position(|byte| *byte == b'#').ok_or_else(expected)?;
    let (digits, rest) = (&frame[..end], &frame[end + 1..]);
    let raw = hex::number(digits).ok_or_else(expected)?;
    let id = match digits.len() {
        3 => can::identifier(raw, false),
        8 if raw & ERROR_FLAG != 0 => return error_frame(raw, rest).ok_or_else(expected),
        8 => can::identifier(raw, true),
        _ => None,
    };
    let id = id.ok_or_else(|| {
        Defect::new("an identifier of 3 digits up to 7FF or 8 up to 1FFFFFFF", digits)
    })?;
    match rest {
        [b'#', flags, data @ ..] => fd_frame(id, *flags, data).ok_or_else(|| {
            Defect::new("flags and 0 to 8, 12, 16, 20, 24, 32, 48 or 64 bytes", rest)
        }),
        [b'R' | b'r', length @ ..] => {
            remote(id, length).ok_or_else(|| Defect::new("a length of 0 to 8 behind `R`", length))
        }
        data => {
            let mut bytes = [0; DATA_BYTES_MAX];
            bytes_of(without_raw_dlc(data), &mut bytes)
                .and_then(|length| CanFrame::new(id, &bytes[..length]))
                .map(Payload::Frame)
                .ok_or_else(|| Defect::new("0 to 8 bytes of two digits", data))
        }
    }
}

/// Reads bytes of two digits each, with optional dots between them, as in can-utils; returns their number.
fn bytes_of(digits: &[u8], bytes: &mut [u8]) -> Option<usize> {
    let mut rest = digits;
    let mut length = 0;
    while let [high, low, more @ ..] = rest {
        *bytes.get_mut(length)? = hex::digit(*high)? << 4 | hex::digit(*low)?;
        length += 1;
        rest = match more {
            [b'.', more @ ..] if !more.is_empty() => more,
            more => more,
        };
    }
    rest.is_empty().then_some(length)
}

/// A classic frame with eight bytes may have a larger DLC, which does not affect its data.
fn without_raw_dlc(text: &[u8]) -> &[u8] {
    match text {
        [text @ .., b'_', dlc] if hex::digit(*dlc).is_some_and(|dlc| dlc > 8) => text,
        text => text,
    }
}

fn remote(id: Id, length: &[u8]) -> Option<Payload> {
    let length = match without_raw_dlc(length) {
        [] => 0,
        [digit] => usize::from(hex::digit(*digit)?),
        _ => return None,
    };
    CanFrame::new_remote(id, length).map(Payload::Frame)
}

fn fd_frame(id: Id, flags: u8, digits: &[u8]) -> Option<Payload> {
    let mut bytes = [0; FD_BYTES_MAX];
    let length = bytes_of(digits, &mut bytes)?;
    let flags = FdFlags::from_bits(hex::digit(flags)?);
    CanFrame::fd(id, flags, &bytes[..length]).map(Payload::Frame)
}

/// Missing details are filled with zeros: python-can writes none.
fn error_frame(raw: u32, digits: &[u8]) -> Option<Payload> {
    let mut details = [0; DATA_BYTES_MAX];
    bytes_of(digits, &mut details)?;
    ErrorFrame::new(raw & !ERROR_FLAG, details).map(Payload::Error)
}

#[derive(Debug)]
pub(crate) struct Writer<W: Write> {
    out: W,
    line: Vec<u8>,
}

impl<W: Write> Writer<W> {
    pub(crate) fn new(out: W) -> Self {
        Self { out, line: Vec::new() }
    }
}

impl<W: Write + fmt::Debug> WriteEntries for Writer<W> {
    /// Bytes of serial lines are left out.
    fn write(&mut self, entry: &Entry) -> io::Result<Kept> {
        let nanos = entry.at.as_nanos().unsigned_abs();
        let line = &mut self.line;
        line.clear();
        let (seconds, micros) = (nanos / 1_000_000_000, nanos % 1_000_000_000 / 1_000);
        write!(line, "({seconds:010}.{micros:06}) {} ", entry.channel)?;
        match &entry.payload {
            Payload::Frame(frame) => {
                push_id(line, frame.id());
                if let Some(flags) = frame.fd_flags() {
                    line.push(b'#');
                    hex::push_number(line, u32::from(flags.bits()), 1);
                }
                if frame.is_remote() {
                    line.extend([b'R', b'0' + frame.dlc() as u8]);
                } else {
                    hex::push_bytes(line, frame.data());
                }
            }
            Payload::Error(error) => {
                hex::push_number(line, error.class() | ERROR_FLAG, 8);
                line.push(b'#');
                hex::push_bytes(line, &error.details);
            }
            Payload::Serial(_) => return Ok(Kept::LeftOut),
        }
        line.extend_from_slice(match entry.direction {
            None => b"\n",
            Some(Direction::Rx) => b" R\n",
            Some(Direction::Tx) => b" T\n",
        });
        self.out.write_all(line)?;
        Ok(Kept::Written)
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        self.out.flush()
    }
}

fn push_id(line: &mut Vec<u8>, id: Id) {
    match id {
        Id::Standard(id) => hex::push_number(line, u32::from(id.as_raw()), 3),
        Id::Extended(id) => hex::push_number(line, id.as_raw(), 8),
    }
    line.push(b'#');
}
