//! A channel's value in a record.

use super::super::super::error::LogError;
use super::super::blocks::{Block, Source};
use super::super::field::Field;
use super::super::variable::SignalData;
use super::super::{
    CN_FIXED, CN_MASTER, CN_MOST, CN_SYNC, CN_VARIABLE, CN_VIRTUAL, CN_VIRTUAL_MASTER,
};
use super::conversion::{Conversion, Ends};

/// Channel flags: all values are missing; values with their bit set are missing.
const CN_ALL_INVALID: u32 = 1;
const CN_HAS_INVALID: u32 = 1 << 1;

/// Longest text in signal data.
const TEXT_BYTES_MAX: usize = 16 * 1024;

#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Unknown: marked so in the file, or not finite.
    Missing,
    Number(f64),
    Text(String),
}

/// Place and meaning of a channel's values.
#[derive(Debug)]
pub(super) struct Values {
    place: Place,
    conversion: Conversion,
    /// Whether to read texts instead of numbers.
    as_text: bool,
    invalid: Invalid,
}

#[derive(Debug)]
enum Place {
    Field(Field),
    /// The number of the record, from 0.
    Count,
    Text(Field, Coding),
    /// In signal data, at the offset in the field.
    Elsewhere(Field, Box<SignalData>, Coding),
}

#[derive(Debug, Clone, Copy)]
enum Coding {
    Latin1,
    Utf8,
    Utf16 { big: bool },
}

#[derive(Debug)]
enum Invalid {
    Never,
    Always,
    /// If that bit is set.
    At(usize, u8),
}

impl Values {
    /// For the channel at that address, in records with these bytes of values and of invalidation bits.
    pub(super) fn of(
        source: &mut Source<'_>,
        address: u64,
        (value_bytes, invalid_bytes): (u64, u64),
        as_text: bool,
        unfinished: bool,
    ) -> Result<Self, LogError> {
        let channel = source.block(address, "##CN")?;
        if channel.link(1) != 0 && source.any_block(channel.link(1))?.mark() == b"##CA" {
            return source.bad(address, "a channel of one value a record", "an array");
        }
        let coding = coding(&channel);
        let place = match (channel.u8(0), coding) {
            (CN_VIRTUAL | CN_VIRTUAL_MASTER, _) => Place::Count,
            (CN_VARIABLE, Some(coding)) => {
                let at = channel.link(5);
                if at != 0 && source.any_block(at)?.mark() == b"##CG" {
                    return source.bad(address, "texts in signal data", "texts among records");
                }
                let data = SignalData::new(at, unfinished, TEXT_BYTES_MAX);
                Place::Elsewhere(Field::place_of(&channel), Box::new(data), coding)
            }
            (CN_FIXED | CN_MASTER | CN_SYNC | CN_MOST, coding) => {
                let field = match Field::of(&channel) {
                    Ok(field) => field,
                    Err(defect) => return Err(source.malformed(address, defect)),
                };
                match coding {
                    Some(coding) => Place::Text(field, coding),
                    None if channel.u8(2) <= 5 => Place::Field(field),
                    None => return source.bad(address, "a number or a text", "other bytes"),
                }
            }
            (kind, _) => {
                return source.bad(
                    address,
                    "a number or a text",
                    format!("a channel of type {kind}"),
                );
            }
        };
        let end = match &place {
            Place::Field(field) | Place::Text(field, _) | Place::Elsewhere(field, ..) => {
                field.end() as u64
            }
            Place::Count => 0,
        };
        if end > value_bytes {
            let found = format!("{end} bytes of {value_bytes}");
            return source.bad(address, "a value within its record", &found);
        }
        let is_text = !matches!(place, Place::Field(_) | Place::Count);
        if is_text && !as_text {
            return source.bad(address, "a channel of numbers", "texts");
        }
        let flags = channel.u32(12);
        let bit = u64::from(channel.u32(16));
        let invalid = match flags {
            flags if flags & CN_ALL_INVALID != 0 => Invalid::Always,
            flags if flags & CN_HAS_INVALID == 0 => Invalid::Never,
            _ if bit / 8 >= invalid_bytes => {
                let found = format!("bit {bit} of {invalid_bytes} bytes");
                return source.bad(address, "an invalidation bit within its record", &found);
            }
            // A record is no longer than a buffer.
            _ => Invalid::At((value_bytes + bit / 8) as usize, 1 << (bit % 8)),
        };
        let ends = match channel.u8(2) {
            4 | 5 => Ends::Beyond,
            _ => Ends::Within,
        };
        let conversion = match is_text {
            true => Conversion::Same,
            false => Conversion::read(source, channel.link(4), ends)?,
        };
        Ok(Self { place, conversion, as_text, invalid })
    }

    /// The value in a record; `number` counts records from 0.
    pub(super) fn cell(
        &mut self,
        record: &[u8],
        number: u64,
        source: &mut Source<'_>,
    ) -> Result<Cell, LogError> {
        let is_missing = match self.invalid {
            Invalid::Never => false,
            Invalid::Always => true,
            Invalid::At(byte, bit) => record.get(byte).is_none_or(|bits| bits & bit != 0),
        };
        if is_missing {
            return Ok(Cell::Missing);
        }
        let raw = match &mut self.place {
            Place::Field(field) => {
                let integer = field.integer(record).map(|number| number as f64);
                integer.or(field.float(record)).unwrap_or(f64::NAN)
            }
            Place::Count => number as f64,
            Place::Text(field, coding) => return Ok(coding.cell(field.bytes(record))),
            Place::Elsewhere(field, data, coding) => {
                let place = field.number(record);
                let bytes = data.get(place, source)?;
                if bytes.len() == TEXT_BYTES_MAX {
                    let found = format!("a longer one at {place}");
                    return source.bad(data.began(), "texts of less than 16384 bytes", found);
                }
                return Ok(coding.cell(&bytes));
            }
        };
        if self.as_text
            && let Some(text) = self.conversion.text(raw)
        {
            return Ok(Cell::Text(text.to_owned()));
        }
        let value = self.conversion.number(raw);
        Ok(if value.is_finite() { Cell::Number(value) } else { Cell::Missing })
    }
}

/// Encoding of a channel's texts; `None` for a channel without texts.
fn coding(channel: &Block) -> Option<Coding> {
    Some(match channel.u8(2) {
        6 => Coding::Latin1,
        7 => Coding::Utf8,
        8 => Coding::Utf16 { big: false },
        9 => Coding::Utf16 { big: true },
        _ => return None,
    })
}

impl Coding {
    /// The text up to a zero; an empty text is missing.
    fn cell(self, bytes: &[u8]) -> Cell {
        let text: String = match self {
            Self::Latin1 => bytes.iter().map(|byte| char::from(*byte)).collect(),
            Self::Utf8 => String::from_utf8_lossy(bytes).into_owned(),
            Self::Utf16 { big } => {
                let pairs = bytes.as_chunks().0.iter();
                let units = pairs.map(|pair| match big {
                    true => u16::from_be_bytes(*pair),
                    false => u16::from_le_bytes(*pair),
                });
                char::decode_utf16(units).map(|one| one.unwrap_or('\u{fffd}')).collect()
            }
        };
        match text.split('\0').next().unwrap_or_default() {
            "" => Cell::Missing,
            text => Cell::Text(text.to_owned()),
        }
    }
}
