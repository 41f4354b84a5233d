//! One message of a TRC file.

use super::super::entry::{Channel, Direction, Entry, ErrorFrame, Payload};
use super::super::error::Defect;
use super::super::{hex, numbers};
use super::head::Column;
use embedded_can::Frame as _;
use wire::can::{self, CanFrame, DATA_BYTES_MAX, FD_BYTES_MAX, FD_LENGTHS, FdFlags, Id};
use wire::time::Timestamp;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// A classic frame; in versions before 2.0 the data show whether it is a remote request.
    Classic,
    Remote,
    Fd(FdFlags),
    Error,
    Other,
}

struct Words<'a> {
    channel: Channel,
    kind: Kind,
    direction: Option<Direction>,
    identifier: &'a [u8],
    /// The number, and whether it is a data length code.
    length: (&'a [u8], bool),
    data: &'a [u8],
}

/// Parses the message of a line in a log that began then, nanoseconds since 1970; `None` if it is not a frame of a CAN
/// bus.
pub(super) fn parse(line: &[u8], columns: &[Column], began: i64) -> Result<Option<Entry>, Defect> {
    let mut words = Words {
        channel: Channel::CAN0,
        kind: Kind::Classic,
        direction: None,
        identifier: b"",
        length: (b"", true),
        data: b"",
    };
    let mut since_start = 0;
    let mut rest = line;
    for column in columns {
        if *column == Column::Data {
            words.data = rest.trim_ascii();
            break;
        }
        let (word, behind) = hex::word(rest);
        rest = behind;
        match column {
            Column::Time => {
                since_start = hex::scaled(word, 1_000_000).ok_or_else(|| {
                    Defect::new("a time in milliseconds such as `17535.400`", word)
                })?;
            }
            Column::Type => (words.kind, words.direction) = kind(word)?,
            Column::Bus if word == b"-" => {}
            Column::Bus => {
                let number = hex::decimal(word).and_then(|number| u32::try_from(number).ok());
                words.channel = number
                    .and_then(numbers::channel)
                    .ok_or_else(|| Defect::new("a bus from 1", word))?;
            }
            // Lines that are not frames have other words from here on.
            Column::Identifier if words.kind == Kind::Other => return Ok(None),
            Column::Identifier if words.kind == Kind::Error => break,
            Column::Identifier => words.identifier = word,
            Column::Direction => {
                let direction = Direction::of_word(word);
                words.direction = Some(direction.ok_or_else(|| Defect::new("`Rx` or `Tx`", word))?);
            }
            Column::Code => words.length = (word, true),
            Column::Length => words.length = (word, false),
            Column::Other | Column::Data => {}
        }
    }
    let Some(payload) = words.payload()? else { return Ok(None) };
    let direction = words.direction.filter(|_| !matches!(payload, Payload::Error(_)));
    let at = began.checked_add(since_start);
    let at = at.ok_or_else(|| Defect::new("a time before 2262", line))?;
    let (at, channel) = (Timestamp::from_nanos(at), words.channel);
    Ok(Some(Entry { at, channel, direction, payload }))
}

/// In versions before 2.0 the type includes the direction.
fn kind(word: &[u8]) -> Result<(Kind, Option<Direction>), Defect> {
    let fd = |bit_rate_switch, error_state| Kind::Fd(FdFlags { bit_rate_switch, error_state });
    Ok(match word {
        b"Rx" | b"Tx" => (Kind::Classic, Direction::of_word(word)),
        b"DT" => (Kind::Classic, None),
        b"RR" => (Kind::Remote, None),
        b"FD" => (fd(false, false), None),
        b"FB" => (fd(true, false), None),
        b"FE" => (fd(false, true), None),
        b"BI" => (fd(true, true), None),
        b"ER" | b"Error" => (Kind::Error, None),
        b"ST" | b"EC" | b"EV" | b"Warng" => (Kind::Other, None),
        other => return Err(Defect::new("a type of message such as `DT`, `FD` or `Rx`", other)),
    })
}

impl Words<'_> {
    fn payload(&self) -> Result<Option<Payload>, Defect> {
        // Version 1.0 has no types: a warning has a special identifier, an error frame a word before its data.
        let is_error = self.kind == Kind::Error || self.data.starts_with(b"ERROR");
        if is_error {
            return Ok(Some(Payload::Error(ErrorFrame::BUS_ERROR)));
        }
        if self.identifier == b"FFFFFFFF" {
            return Ok(None);
        }
        let id = identifier(self.identifier)?;
        let (word, is_code) = self.length;
        let length = hex::decimal(word).and_then(|length| usize::try_from(length).ok());
        let length = length.ok_or_else(|| Defect::new("a length of the data", word))?;
        let classic = if is_code { length.min(DATA_BYTES_MAX) } else { length };
        let frame = match self.kind {
            Kind::Fd(flags) => Some(self.fd(id, flags, length)?),
            Kind::Remote => CanFrame::new_remote(id, classic),
            _ if self.data == b"RTR" => CanFrame::new_remote(id, classic),
            // A J1939 message assembled from several frames.
            _ if classic > DATA_BYTES_MAX => return Ok(None),
            _ => {
                let mut bytes = [0; DATA_BYTES_MAX];
                let given = bytes_of(self.data, &mut bytes);
                let data = given.filter(|given| *given == classic).map(|_| &bytes[..classic]);
                CanFrame::new(id, data.ok_or_else(|| self.not_as_long())?)
            }
        };
        let frame = frame.ok_or_else(|| Defect::new("a length of at most 8", word))?;
        Ok(Some(Payload::Frame(frame)))
    }

    fn fd(&self, id: Id, flags: FdFlags, length: usize) -> Result<CanFrame, Defect> {
        let mut bytes = [0; FD_BYTES_MAX];
        let given = bytes_of(self.data, &mut bytes).ok_or_else(|| self.not_as_long())?;
        let by_code = FD_LENGTHS.get(length).map(|length| usize::from(*length));
        if given != length && !(self.length.1 && by_code == Some(given)) {
            return Err(self.not_as_long());
        }
        CanFrame::fd(id, flags, &bytes[..given])
            .ok_or_else(|| Defect::new("0 to 8, 12, 16, 20, 24, 32, 48 or 64 bytes", self.length.0))
    }

    fn not_as_long(&self) -> Defect {
        Defect::new("as many bytes of two digits as the length says", self.data)
    }
}

fn identifier(digits: &[u8]) -> Result<Id, Defect> {
    let id = hex::number(digits).and_then(|raw| can::identifier(raw, digits.len() > 4));
    let expected = "an identifier of 4 digits up to 07FF or 8 up to 1FFFFFFF";
    id.ok_or_else(|| Defect::new(expected, digits))
}

/// Reads bytes of two digits with blanks between them; returns their number.
fn bytes_of(text: &[u8], bytes: &mut [u8]) -> Option<usize> {
    let mut rest = text;
    let mut length = 0;
    loop {
        let (word, behind) = hex::word(rest);
        match word {
            [] => return Some(length),
            [high, low] => *bytes.get_mut(length)? = hex::digit(*high)? << 4 | hex::digit(*low)?,
            _ => return None,
        }
        length += 1;
        rest = behind;
    }
}
