//! One event of an ASC file, after its time.

use super::super::entry::{Channel, Direction, ErrorFrame, Payload};
use super::super::error::Defect;
use super::super::{hex, numbers};
use super::{EDL, RTR};
use embedded_can::Frame as _;
use wire::can::{self, CanFrame, DATA_BYTES_MAX, FD_BYTES_MAX, FD_LENGTHS, FdFlags, Id};

/// Number base of identifiers, data and DLC.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Base {
    Hex,
    Dec,
}

impl Base {
    fn number(self, text: &[u8]) -> Option<u32> {
        match self {
            Self::Hex => hex::number(text),
            Self::Dec => hex::decimal(text).and_then(|number| u32::try_from(number).ok()),
        }
    }
}

pub(super) type OnBus = (Channel, Option<Direction>, Payload);

struct Words<'a>(&'a [u8]);

impl<'a> Words<'a> {
    fn next(&mut self) -> &'a [u8] {
        let (word, rest) = hex::word(self.0);
        self.0 = rest;
        word
    }

    fn peek(&self) -> &'a [u8] {
        hex::word(self.0).0
    }
}

/// Parses an event; `None` if it is not a frame of a CAN bus.
pub(super) fn parse(text: &[u8], base: Base) -> Result<Option<OnBus>, Defect> {
    let mut words = Words(text);
    let first = words.next();
    if first == b"CANFD" {
        return fd(&mut words, base).map(Some);
    }
    let Some(channel) = channel(first) else { return Ok(None) };
    let name = words.next();
    if is_error_frame(name) {
        return Ok(Some((channel, None, Payload::Error(ErrorFrame::BUS_ERROR))));
    }
    // `TxRq` is a frame that is still to be sent.
    let Some(direction) = Direction::of_word(words.next()) else { return Ok(None) };
    let id = identifier(name, base)?;
    let payload = match words.next() {
        b"d" | b"D" => data_frame(id, &mut words, base)?,
        b"r" | b"R" => remote(id, &mut words, base)?,
        other => return Err(Defect::new("`d` for data or `r` for a remote request", other)),
    };
    Ok(Some((channel, Some(direction), payload)))
}

fn is_error_frame(word: &[u8]) -> bool {
    word.eq_ignore_ascii_case(b"ErrorFrame")
}

fn channel(word: &[u8]) -> Option<Channel> {
    let number = hex::decimal(word).and_then(|number| u32::try_from(number).ok())?;
    numbers::channel(number)
}

fn identifier(word: &[u8], base: Base) -> Result<Id, Defect> {
    let (digits, extended) = match word {
        [digits @ .., b'x' | b'X'] => (digits, true),
        digits => (digits, false),
    };
    let id = base.number(digits).and_then(|raw| can::identifier(raw, extended));
    let expected = match base {
        Base::Hex => "an identifier up to 7FF, or up to 1FFFFFFFx",
        Base::Dec => "an identifier up to 2047, or up to 536870911x",
    };
    id.ok_or_else(|| Defect::new(expected, word))
}

fn data_frame(id: Id, words: &mut Words<'_>, base: Base) -> Result<Payload, Defect> {
    let code = words.next();
    // A DLC of 9 to 15 in a classic frame means eight bytes (ISO 11898-1).
    let length = base
        .number(code)
        .filter(|code| *code < 16)
        .map(|code| (code as usize).min(DATA_BYTES_MAX))
        .ok_or_else(|| Defect::new("a data length code of 0 to 15", code))?;
    let mut data = [0; DATA_BYTES_MAX];
    read_bytes(&mut data[..length], words, base)?;
    CanFrame::new(id, &data[..length])
        .map(Payload::Frame)
        .ok_or_else(|| Defect::new("at most 8 bytes", code))
}

/// The length is missing in files of tools before 8.5, and a remote request may be followed by a statistic (`Length =
/// ...`).
fn remote(id: Id, words: &mut Words<'_>, base: Base) -> Result<Payload, Defect> {
    let code = words.next();
    let length = base.number(code).map_or(0, |code| (code as usize).min(DATA_BYTES_MAX));
    CanFrame::new_remote(id, length)
        .map(Payload::Frame)
        .ok_or_else(|| Defect::new("a length of at most 8", code))
}

fn read_bytes(bytes: &mut [u8], words: &mut Words<'_>, base: Base) -> Result<(), Defect> {
    for byte in bytes {
        let word = words.next();
        *byte = base
            .number(word)
            .and_then(|number| u8::try_from(number).ok())
            .ok_or_else(|| Defect::new("as many bytes as the length says", word))?;
    }
    Ok(())
}

/// `CANFD channel direction identifier [name] BRS ESI DLC length data... duration length flags ...`
fn fd(words: &mut Words<'_>, base: Base) -> Result<OnBus, Defect> {
    let word = words.next();
    let channel = channel(word).ok_or_else(|| Defect::new("a channel from 1", word))?;
    let word = words.next();
    let direction = Direction::of_word(word).ok_or_else(|| Defect::new("`Rx` or `Tx`", word))?;
    let word = words.next();
    if is_error_frame(word) {
        return Ok((channel, Some(direction), Payload::Error(ErrorFrame::BUS_ERROR)));
    }
    let id = identifier(word, base)?;
    if !matches!(words.peek(), b"0" | b"1") {
        // Name of the message in a database.
        words.next();
    }
    let bit_rate_switch = flag(words)?;
    let error_state = flag(words)?;
    let code = words.next();
    let nominal = base
        .number(code)
        .and_then(|code| FD_LENGTHS.get(code as usize))
        .ok_or_else(|| Defect::new("a data length code of 0 to f", code))?;
    let word = words.next();
    let length = hex::decimal(word)
        .and_then(|length| usize::try_from(length).ok())
        .filter(|length| *length <= FD_BYTES_MAX)
        .ok_or_else(|| Defect::new("a length of at most 64", word))?;
    let mut data = [0; FD_BYTES_MAX];
    read_bytes(&mut data[..length], words, base)?;
    let _duration_ns = words.next();
    let _bits = words.next();
    // Without flags, or with none set as in older files, the event is a CAN FD frame, as its name says.
    let flags = hex::number(words.next()).filter(|flags| *flags != 0).unwrap_or(EDL);
    let data = &data[..length];
    let frame = if flags & EDL != 0 {
        CanFrame::fd(id, FdFlags { bit_rate_switch, error_state }, data)
    } else if flags & RTR != 0 {
        CanFrame::new_remote(id, usize::from(*nominal).min(DATA_BYTES_MAX))
    } else {
        CanFrame::new(id, data)
    };
    let frame = frame.ok_or_else(|| Defect::new("a length that such a frame can have", word))?;
    Ok((channel, Some(direction), Payload::Frame(frame)))
}

fn flag(words: &mut Words<'_>) -> Result<bool, Defect> {
    match words.next() {
        b"0" => Ok(false),
        b"1" => Ok(true),
        other => Err(Defect::new("`0` or `1`", other)),
    }
}
