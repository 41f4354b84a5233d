//! ASAM MDF 4.1, measured channels: quantities over time, as measuring tools keep them.
//!
//! A group has records of the same channels. Its master channel is the time of a record, in seconds.
//!
//! | [`Kind`] | in a record of a file that is written | conversion |
//! |---|---|---|
//! | `Float` | 64 bits, floating point | none, or value to text (7) where values have names |
//! | `Integer` | 64 bits with a sign | the same |
//! | `Bool` | 8 bits without a sign | none |
//! | `Choice` | 16 bits without a sign: numbers of texts in the order in which these come | value to text (7) |
//! | `Text` | 64 bits: where the text is in signal data (`SD`) | none |
//!
//! A value that is missing is marked by an invalidation bit; a floating-point one is not a number besides. Names, units and
//! descriptions of channels and groups stand in the file. Groups are sorted and compressed by deflate (`HL`, `DL`, `DZ`).
//!
//! Read are numbers of any size and byte order at any bit, texts, and values that are counted (virtual channels), in
//! groups that are sorted or not, in `DT`, `DZ`, `DL` and `HL` blocks. Conversions: linear, rational, tables with and without
//! interpolation, ranges, value and range to text. Arrays, algebra and columns (`DV`, 4.2) are refused. Of a file that was not
//! finished comes what is there.
//!
//! Source: ASAM MDF 4.1.1, as far as asammdf's `v4_blocks.py` and `v4_constants.py` show it.

mod contents;
mod conversion;
mod describe;
mod read;
mod values;
mod write;

pub use contents::{Channel, Group};
pub use read::{Found, Reader, Wanted};
pub use values::Cell;
pub use write::{GroupId, Writer};

/// What a channel holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Real numbers.
    Float,
    /// Whole numbers.
    Integer,
    /// Yes or no: 1 or 0.
    Bool,
    /// One of a few texts, of which at most 4,096 are told apart; further ones are missing.
    Choice,
    /// Any text, UTF-8.
    Text,
}

/// A channel that is to be written.
#[derive(Debug, Clone, PartialEq)]
pub struct Form {
    /// Name, unique in its group.
    pub name: String,
    /// What it holds.
    pub kind: Kind,
    /// Unit of its values; empty where it has none.
    pub unit: String,
    /// What it is; may be empty.
    pub doc: String,
    /// Names of values, by the values in that unit, of a channel of numbers; at most 4,096 are written.
    pub names: Vec<(f64, String)>,
}

/// A value of a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value<'a> {
    /// Not known.
    Missing,
    /// Of a [`Kind::Float`] channel. What is not a number counts as missing.
    Float(f64),
    /// Of a [`Kind::Integer`] channel.
    Integer(i64),
    /// Of a [`Kind::Bool`] channel.
    Bool(bool),
    /// Of a [`Kind::Choice`] or [`Kind::Text`] channel.
    Text(&'a str),
}

impl Kind {
    /// Bytes in a record.
    const fn bytes(self) -> u32 {
        match self {
            Self::Float | Self::Integer | Self::Text => 8,
            Self::Bool => 1,
            Self::Choice => 2,
        }
    }
}
