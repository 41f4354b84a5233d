//! Writes an ASC file: `base hex  timestamps absolute`.

use super::super::entry::{Channel, Direction, Entry, Payload};
use super::super::numbers::{CHANNELS_MAX, Numbers};
use super::super::{Kept, WriteEntries, hex};
use super::{BRS, EDL, ESI, date};
use embedded_can::Frame as _;
use std::fmt::{self, Display};
use std::io::{self, Write};
use wire::can::{CanFrame, FdFlags, Id};

const NANOS_A_MILLISECOND: i64 = 1_000_000;

/// Writes an ASC file.
///
/// The date in its head is that of the first entry, to the millisecond; earlier entries are put at zero. `canN` gets
/// channel N + 1 if that is free, any other name the lowest free one; a comment before its first entry has the name.
/// Entries beyond 32 channels are left out. An entry with unknown direction counts as received, because the format cannot
/// express it.
#[derive(Debug)]
pub(crate) struct Writer<W: Write> {
    out: W,
    /// Time of the date in the head, ns; `None` before the first entry.
    began: Option<i64>,
    numbers: Numbers,
    line: Vec<u8>,
}

impl<W: Write> Writer<W> {
    pub(crate) fn new(out: W) -> Self {
        let numbers = Numbers::up_to(CHANNELS_MAX);
        Self { out, began: None, numbers, line: Vec::new() }
    }
}

impl<W: Write + fmt::Debug> WriteEntries for Writer<W> {
    /// Bytes of serial lines are left out, and so are the details of an error frame.
    fn write(&mut self, entry: &Entry) -> io::Result<Kept> {
        if matches!(entry.payload, Payload::Serial(_)) {
            return Ok(Kept::LeftOut);
        }
        let at = entry.at.as_nanos();
        let Some((number, is_new)) = self.numbers.of(entry.channel) else {
            return Ok(Kept::LeftOut);
        };
        let began = match self.began {
            Some(began) => began,
            None => self.head(at)?,
        };
        let micros = (at - began).max(0) / 1_000;
        let (seconds, micros) = (micros / 1_000_000, micros % 1_000_000);
        self.line.clear();
        let line = &mut self.line;
        if is_new {
            writeln!(line, "// channel {number} is {}", entry.channel)?;
        }
        let way = entry.direction.unwrap_or(Direction::Rx).word();
        let written =
            write!(line, "{seconds:4}.{micros:06} ").and_then(|()| match &entry.payload {
                Payload::Frame(frame) => {
                    if let Some(flags) = frame.fd_flags() {
                        return fd(line, number, way, frame, flags);
                    }
                    let id = Identifier(frame.id());
                    let kind = if frame.is_remote() { 'r' } else { 'd' };
                    write!(line, "{number}  {id:<15} {way:<4} {kind} {:x}", frame.dlc())?;
                    hex::push_spaced(line, frame.data());
                    Ok(())
                }
                Payload::Error(_) => write!(line, "{number}  ErrorFrame"),
                Payload::Serial(_) => Ok(()),
            });
        self.line.push(b'\n');
        written.and_then(|()| self.out.write_all(&self.line))?;
        Ok(Kept::Written)
    }

    fn numbered(&self) -> Vec<(usize, Channel)> {
        self.numbers.named()
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        if self.began.is_none() {
            self.head(0)?;
        }
        writeln!(self.out, "End TriggerBlock").and_then(|()| self.out.flush())
    }
}

impl<W: Write> Writer<W> {
    fn head(&mut self, at: i64) -> io::Result<i64> {
        let began = at - at % NANOS_A_MILLISECOND;
        self.began = Some(began);
        let date = date::format(began);
        let head = format!(
            "date {date}\nbase hex  timestamps absolute\ninternal events logged\n\
             Begin Triggerblock {date}\n   0.000000 Start of measurement\n"
        );
        self.out.write_all(head.as_bytes())?;
        Ok(began)
    }
}

/// Duration, bits on the wire, CRC and bit timing are unknown here: zero, as in python-can.
fn fd(
    line: &mut Vec<u8>,
    number: usize,
    way: &str,
    frame: &CanFrame,
    flags: FdFlags,
) -> io::Result<()> {
    let (id, name) = (Identifier(frame.id()), "");
    let (brs, esi) = (flags.bit_rate_switch, flags.error_state);
    let flags = EDL | if brs { BRS } else { 0 } | if esi { ESI } else { 0 };
    let (brs, esi, dlc, length) = (u8::from(brs), u8::from(esi), frame.dlc(), frame.data().len());
    write!(line, "CANFD {number:>3} {way:<4} {id:>8}  {name:>32} {brs} {esi} {dlc:x} {length:>2}")?;
    hex::push_spaced(line, frame.data());
    write!(line, " {:>8} {:>4} {flags:>8X}", 0, 0)?;
    (0..5).try_for_each(|_| write!(line, " {:>8}", 0))
}

/// Hexadecimal, with an `x` after an extended identifier.
struct Identifier(Id);

impl Display for Identifier {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Id::Standard(id) => f.pad(&format!("{:X}", id.as_raw())),
            Id::Extended(id) => f.pad(&format!("{:X}x", id.as_raw())),
        }
    }
}
