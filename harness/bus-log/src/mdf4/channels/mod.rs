//! ASAM MDF 4.1, measured channels: quantities over time, as stored by measurement tools.
//!
//! The records of a group have the same channels. Its master channel is the time of a record, in seconds.
//!
//! | [`Kind`] | in a record of a file that is written | conversion |
//! |---|---|---|
//! | `Float` | 64 bits, floating point | none, or value to text (7) where values have names |
//! | `Integer` | 64 bits with a sign | the same |
//! | `Bool` | 8 bits without a sign | none |
//! | `Choice` | 16 bits without a sign: numbers of texts in the order in which these come | value to text (7) |
//! | `Text` | 64 bits: where the text is in signal data (`SD`) | none |
//!
//! A missing value is marked by an invalidation bit; a missing floating-point value is also NaN. Names, units and
//! descriptions of channels and groups are in the file. Groups are sorted and compressed by deflate (`HL`, `DL`, `DZ`).
//!
//! The reader handles numbers of any size and byte order at any bit, texts, and counted values (virtual channels), in
//! sorted and unsorted groups, in `DT`, `DZ`, `DL` and `HL` blocks, and in column-oriented storage (4.2: `DV`, `DI` and
//! `LD` blocks, with the times in another group). Conversions: linear, rational, tables with and without interpolation,
//! ranges, value and range to text. Arrays and algebra are refused. An unfinished file is read as far as it goes.
//!
//! Source: ASAM MDF 4.1.1 and 4.2, as far as asammdf's `v4_blocks.py` and `v4_constants.py` show it.

mod contents;
mod conversion;
mod read;
mod records;
mod values;
mod write;

pub use contents::{Channel, Group};
pub use read::{Found, Reader, Wanted};
pub use values::Cell;
pub use write::{GroupId, Writer};

/// Type of a channel's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Float,
    Integer,
    /// Yes or no: 1 or 0.
    Bool,
    /// One of a few texts, of which at most 4,096 are distinguished; further ones are missing.
    Choice,
    /// Any text, UTF-8.
    Text,
}

/// Description of a channel to write.
#[derive(Debug, Clone, PartialEq)]
pub struct Form {
    /// Name, unique in its group.
    pub name: String,
    pub kind: Kind,
    /// Unit of its values; empty without a unit.
    pub unit: String,
    /// Its meaning; may be empty.
    pub doc: String,
    /// Names of values, by value in that unit, for a channel of numbers; at most 4,096 are written.
    pub names: Vec<(f64, String)>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value<'a> {
    Missing,
    /// In a [`Kind::Float`] channel. NaN counts as missing.
    Float(f64),
    /// In a [`Kind::Integer`] channel.
    Integer(i64),
    /// In a [`Kind::Bool`] channel.
    Bool(bool),
    /// In a [`Kind::Choice`] or [`Kind::Text`] channel.
    Text(&'a str),
}

impl Kind {
    const fn bytes(self) -> u32 {
        match self {
            Self::Float | Self::Integer | Self::Text => 8,
            Self::Bool => 1,
            Self::Choice => 2,
        }
    }
}
