//! The object dictionary of a device (CiA 301, 7.4), as its EDS describes it.

use super::abort::Abort;
use crate::layout::{Coding, Note, Scale};
use std::ops::Range;

/// Objects below this index belong to the communication, those from it on to the application (CiA 301, 7.4.1).
pub(super) const APPLICATION: u16 = 0x2000;

/// The objects of a device, and its node identifier.
#[derive(Debug, Clone, PartialEq)]
pub struct Dictionary {
    pub(super) node_id: u8,
    /// In ascending order of index and sub-index.
    pub(super) entries: Vec<Entry>,
    /// Contradictions in the file.
    pub(crate) notes: Vec<Note>,
}

/// An object that can be read or written: one sub-index.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    pub(super) index: u16,
    pub(super) sub: u8,
    /// Its name in expressions and plans.
    pub(super) name: String,
    /// `ParameterName` of the EDS.
    pub(super) title: String,
    pub(super) kind: Kind,
    pub(crate) readable: bool,
    pub(super) writable: bool,
    pub(super) mappable: bool,
    /// The smallest and the largest number on the wire.
    pub(super) limits: (f64, f64),
    /// Its bytes at power-on.
    pub(super) start: Vec<u8>,
    pub(crate) unit: String,
    pub(super) scale: Scale,
    /// Its value in the EDS, or its section.
    pub(super) at: Range<usize>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// A number of this many bits.
    Number(Coding, u32),
    /// Text or other bytes, of any length.
    Bytes,
}

impl Kind {
    /// The type with this number (CiA 301, table 44); `None` if it has no values.
    pub(super) const fn of(data_type: u64) -> Option<Self> {
        Some(match data_type {
            0x01 => Self::Number(Coding::Unsigned, 1),
            0x02 => Self::Number(Coding::Signed, 8),
            0x03 => Self::Number(Coding::Signed, 16),
            0x04 => Self::Number(Coding::Signed, 32),
            0x05 => Self::Number(Coding::Unsigned, 8),
            0x06 => Self::Number(Coding::Unsigned, 16),
            0x07 => Self::Number(Coding::Unsigned, 32),
            0x08 => Self::Number(Coding::Float32, 32),
            0x09 | 0x0A | 0x0B | 0x0F => Self::Bytes,
            0x0C | 0x0D | 0x19 => Self::Number(Coding::Unsigned, 48),
            0x10 => Self::Number(Coding::Signed, 24),
            0x11 => Self::Number(Coding::Float64, 64),
            0x12 => Self::Number(Coding::Signed, 40),
            0x13 => Self::Number(Coding::Signed, 48),
            0x14 => Self::Number(Coding::Signed, 56),
            0x15 => Self::Number(Coding::Signed, 64),
            0x16 => Self::Number(Coding::Unsigned, 24),
            0x18 => Self::Number(Coding::Unsigned, 40),
            0x1A => Self::Number(Coding::Unsigned, 56),
            0x1B => Self::Number(Coding::Unsigned, 64),
            _ => return None,
        })
    }

    /// Number of bytes of a number; zero for anything else.
    pub(super) const fn bytes(self) -> usize {
        match self {
            Self::Number(_, bits) => bits.div_ceil(8) as usize,
            Self::Bytes => 0,
        }
    }
}

impl Entry {
    /// Its name in expressions and plans.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Unit of its values, as the device file states it; may be empty.
    pub fn unit(&self) -> &str {
        &self.unit
    }

    /// `ParameterName` of the EDS.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// True if masters may write it.
    pub const fn is_writable(&self) -> bool {
        self.writable
    }

    /// Its value at power-on; zero if it is not a number.
    pub fn start(&self) -> f64 {
        self.value(&self.start).unwrap_or(0.0)
    }

    /// Coding and number of bits, if it is a number.
    pub(super) const fn number(&self) -> Option<(Coding, u32)> {
        match self.kind {
            Kind::Number(coding, bits) => Some((coding, bits)),
            Kind::Bytes => None,
        }
    }

    /// Number of its bytes, if it is a number.
    pub fn length(&self) -> Option<usize> {
        self.number().map(|_| self.kind.bytes())
    }

    /// The value of these bytes, in its unit; `None` if it is not a number or they are fewer or more than it has.
    pub fn value(&self, bytes: &[u8]) -> Option<f64> {
        let (coding, bits) = self.number()?;
        if bytes.len() != self.kind.bytes() {
            return None;
        }
        let raw = unsigned(bytes) & (u64::MAX >> (u64::BITS - bits));
        Some(self.scale.physical(coding.number(raw, bits)))
    }

    /// The bytes of a value in its unit, whether it is in its limits or not; `None` if its type cannot have it.
    pub fn bytes(&self, value: f64) -> Option<Vec<u8>> {
        let (coding, bits) = self.number()?;
        let raw = coding.raw(value, bits, self.scale, (f64::MIN, f64::MAX))?;
        Some(raw.to_le_bytes()[..self.kind.bytes()].to_vec())
    }

    /// The value that a device gets, where the object counts in steps and `value` is between two of them.
    pub fn sent_instead_of(&self, value: f64) -> Option<f64> {
        let (coding, _) = self.number()?;
        let sent = self.value(&self.bytes(value)?)?;
        let step = self.scale.factor.abs();
        (!coding.is_float() && self.scale.is_another(sent, value, step)).then_some(sent)
    }

    /// The smallest and the largest value, in its unit.
    pub(super) fn range(&self) -> (f64, f64) {
        self.scale.range(self.limits.0, self.limits.1)
    }

    /// Checks bytes that a master writes.
    pub(super) fn check(&self, bytes: &[u8]) -> Result<(), Abort> {
        if !self.writable {
            return Err(Abort::READ_ONLY);
        }
        let Some((coding, bits)) = self.number() else { return Ok(()) };
        match bytes.len().cmp(&(self.kind.bytes())) {
            std::cmp::Ordering::Less => return Err(Abort::TOO_SHORT),
            std::cmp::Ordering::Greater => return Err(Abort::TOO_LONG),
            std::cmp::Ordering::Equal => {}
        }
        let raw = unsigned(bytes);
        let number = coding.number(raw, bits);
        if number > self.limits.1 || (bits < u64::BITS && raw >> bits > 0) {
            return Err(Abort::TOO_HIGH);
        }
        if number < self.limits.0 {
            return Err(Abort::TOO_LOW);
        }
        if number.is_nan() { Err(Abort::RANGE) } else { Ok(()) }
    }
}

impl Dictionary {
    /// The node identifier.
    pub const fn node_id(&self) -> u8 {
        self.node_id
    }

    /// The object at this index and sub-index.
    ///
    /// # Errors
    /// The abort code that a device sends if the object does not exist.
    pub fn find(&self, index: u16, sub: u8) -> Result<&Entry, Abort> {
        self.position(index, sub).map(|place| &self.entries[place])
    }

    pub(super) fn position(&self, index: u16, sub: u8) -> Result<usize, Abort> {
        let place = |entry: &Entry| (entry.index, entry.sub).cmp(&(index, sub));
        self.entries.binary_search_by(place).map_err(|near| {
            let around = [near.checked_sub(1), Some(near)].into_iter().flatten();
            let mut around = around.filter_map(|place| self.entries.get(place));
            if around.any(|entry| entry.index == index) { Abort::NO_SUB } else { Abort::NO_OBJECT }
        })
    }

    /// The number in an object of the communication; `None` if there is no such object.
    pub(super) fn setting(&self, values: &[Vec<u8>], index: u16, sub: u8) -> Option<u64> {
        self.position(index, sub).ok().map(|place| unsigned(&values[place]))
    }

    /// The place of the object of the application with this name.
    pub(crate) fn named(&self, name: &str) -> Option<usize> {
        self.application().find(|(_, entry)| entry.name == name).map(|(place, _)| place)
    }

    /// The bytes of all objects at power-on.
    pub(super) fn start(&self) -> Vec<Vec<u8>> {
        self.entries.iter().map(|entry| entry.start.clone()).collect()
    }

    /// The objects of the application that are numbers.
    pub fn objects(&self) -> impl Iterator<Item = &Entry> {
        self.application().map(|(_, entry)| entry)
    }

    /// True if the device sends its PDO of this number, from 1, by itself or at a SYNC; it does not if a remote request
    /// or an event before a SYNC has to come.
    pub fn sends_pdo(&self, number: u16) -> bool {
        let kind = self.find(0x17FF + number, 2).ok().map(Entry::start);
        kind.is_none_or(|kind| !(252.0..254.0).contains(&kind))
    }

    /// The objects of the application that are numbers, each with its position.
    pub(crate) fn application(&self) -> impl Iterator<Item = (usize, &Entry)> {
        let all = self.entries.iter().enumerate();
        all.filter(|(_, entry)| entry.index >= APPLICATION && entry.number().is_some())
    }
}

/// Up to eight bytes as a number, the least significant one first.
pub(super) fn unsigned(bytes: &[u8]) -> u64 {
    bytes.iter().take(8).rev().fold(0, |number, byte| number << 8 | u64::from(*byte))
}
