//! Process data objects: their parameters and their mapping, as the dictionary has them.

use super::abort::Abort;
use super::dictionary::{Dictionary, Kind, unsigned};
use wire::can::{self, Id};
use wire::time::Span;

const BITS_MAX: u32 = 64;
/// Most PDOs of a direction (CiA 301, 7.5.1).
const NUMBER_MAX: u16 = 512;
/// Bits of a COB-ID: it is not valid; no remote requests; 29 bits.
const INVALID: u32 = 1 << 31;
const NO_RTR: u32 = 1 << 30;
const EXTENDED: u32 = 1 << 29;
const IDENTIFIER: u32 = 0x1FFF_FFFF;
/// Transmission types that are reserved.
const RESERVED: std::ops::RangeInclusive<u64> = 241..=251;

/// Who sends a PDO.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Direction {
    /// The device.
    Transmit,
    /// Other nodes.
    Receive,
}

impl Direction {
    /// The first objects of parameters and of mappings.
    const fn objects(self) -> (u16, u16) {
        match self {
            Self::Transmit => (0x1800, 0x1A00),
            Self::Receive => (0x1400, 0x1600),
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pdo {
    /// From 1.
    pub(super) number: u16,
    cob: u32,
    pub(super) kind: u8,
    pub(super) inhibit: Span,
    /// Zero without an event timer.
    pub(super) event: Span,
    pub(super) mapped: Vec<Mapped>,
}

/// A part of a PDO.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Mapped {
    /// The place of the object in the dictionary; `None` for bits that nobody uses.
    pub(super) entry: Option<usize>,
    pub(super) bits: u32,
}

/// A mistake in a mapping: index, sub-index and reason.
pub(super) type Wrong = (u16, u8, Abort);

/// The PDOs of a direction that have parameters.
///
/// # Errors
/// With the object of the first mapping that is not possible.
pub(super) fn pdos(
    dictionary: &Dictionary,
    values: &[Vec<u8>],
    direction: Direction,
) -> Result<Vec<Pdo>, Wrong> {
    let (settings, _) = direction.objects();
    let pdo = |offset: u16| {
        let setting = |sub: u8| dictionary.setting(values, settings + offset, sub);
        let cob = setting(1)? as u32;
        let mapped = mapping(dictionary, values, direction, offset);
        Some(mapped.map(|mapped| Pdo {
            number: offset + 1,
            cob,
            kind: setting(2).map_or(u8::MAX, |kind| kind as u8),
            inhibit: Span::from_micros(100 * setting(3).unwrap_or(0).min(0xFFFF) as i64),
            event: Span::from_millis(setting(5).unwrap_or(0).min(0xFFFF) as i64),
            mapped,
        }))
    };
    (0..NUMBER_MAX).filter_map(pdo).collect()
}

fn mapping(
    dictionary: &Dictionary,
    values: &[Vec<u8>],
    direction: Direction,
    offset: u16,
) -> Result<Vec<Mapped>, Wrong> {
    let index = direction.objects().1 + offset;
    let count = dictionary.setting(values, index, 0).unwrap_or(0);
    let (mut all, mut bits) = (Vec::new(), 0);
    for sub in 1..=u8::try_from(count).unwrap_or(u8::MAX) {
        let wrong = |abort: Abort| (index, sub, abort);
        // Bits that move a PDO beyond its end are as many as it has: see 254 and 255, special values of sub-index 0.
        let word = dictionary.setting(values, index, sub).ok_or(wrong(Abort::NO_SUB))? as u32;
        let mapped = mapped(dictionary, word, direction).map_err(wrong)?;
        bits += mapped.bits;
        if bits > BITS_MAX {
            return Err(wrong(Abort::PDO_LENGTH));
        }
        all.push(mapped);
    }
    Ok(all)
}

/// The object that an entry of a mapping names.
fn mapped(dictionary: &Dictionary, word: u32, direction: Direction) -> Result<Mapped, Abort> {
    let (index, sub, bits) = ((word >> 16) as u16, (word >> 8) as u8, word & 0xFF);
    // Objects with the number of a type stand for bits that nobody uses.
    if let (Direction::Receive, 1..=0x1F, Some(Kind::Number(_, own))) =
        (direction, index, Kind::of(index.into()))
    {
        let unused = Mapped { entry: None, bits };
        return if own == bits { Ok(unused) } else { Err(Abort::PDO_LENGTH) };
    }
    let place = dictionary.position(index, sub).map_err(|_| Abort::NO_OBJECT)?;
    let entry = &dictionary.entries[place];
    let may = match direction {
        Direction::Transmit => entry.readable,
        Direction::Receive => entry.writable,
    };
    match entry.number() {
        Some((_, own)) if may && own == bits => Ok(Mapped { entry: Some(place), bits }),
        Some((_, own)) if own != bits => Err(Abort::PDO_LENGTH),
        _ => Err(Abort::NOT_MAPPABLE),
    }
}

/// Checks what a master writes to the parameters and the mapping of a PDO.
pub(super) fn check(
    dictionary: &Dictionary,
    values: &[Vec<u8>],
    (index, sub): (u16, u8),
    bytes: &[u8],
) -> Result<(), Abort> {
    let (direction, is_mapping) = match index {
        0x1400..=0x15FF => (Direction::Receive, false),
        0x1600..=0x17FF => (Direction::Receive, true),
        0x1800..=0x19FF => (Direction::Transmit, false),
        0x1A00..=0x1BFF => (Direction::Transmit, true),
        _ => return Ok(()),
    };
    let offset = index & 0x1FF;
    let (settings, _) = direction.objects();
    let cob = dictionary.setting(values, settings + offset, 1).unwrap_or(INVALID.into()) as u32;
    let is_valid = cob & INVALID == 0;
    let new = unsigned(bytes);
    match (is_mapping, sub) {
        // The identifier of a valid PDO stays (CiA 301, 7.5.2.35).
        (false, 1)
            if is_valid && new as u32 & INVALID == 0 && (new as u32 ^ cob) & !NO_RTR != 0 =>
        {
            Err(Abort::RANGE)
        }
        (false, 1) if new as u32 & INVALID == 0 && id(new as u32).is_none() => Err(Abort::RANGE),
        (false, 2) if RESERVED.contains(&new) => Err(Abort::RANGE),
        (false, 3) if is_valid => Err(Abort::ACCESS),
        (false, _) => Ok(()),
        (true, _) if is_valid => Err(Abort::ACCESS),
        (true, 0) => {
            let mut values = values.to_vec();
            let place = dictionary.position(index, 0)?;
            values[place] = bytes.to_vec();
            mapping(dictionary, &values, direction, offset).map(drop).map_err(|(.., why)| match why
            {
                Abort::NO_SUB => Abort::RANGE,
                other => other,
            })
        }
        (true, _) if dictionary.setting(values, index, 0) != Some(0) => Err(Abort::NOT_EMPTY),
        (true, _) if new == 0 => Ok(()),
        (true, _) => match mapped(dictionary, new as u32, direction)?.entry {
            Some(place) if !dictionary.entries[place].mappable => Err(Abort::NOT_MAPPABLE),
            _ => Ok(()),
        },
    }
}

/// The identifier of a COB-ID.
pub(super) fn id(cob: u32) -> Option<Id> {
    can::identifier(cob & IDENTIFIER, cob & EXTENDED != 0)
}

impl Pdo {
    /// Its identifier; `None` while it is not used.
    pub(super) fn id(&self) -> Option<Id> {
        if self.is_used() { id(self.cob) } else { None }
    }

    /// Whether it is valid and carries something. One with the identifier 0, which is that of NMT, is not used: so do the
    /// files of many devices leave out what they could have.
    const fn is_used(&self) -> bool {
        self.cob & INVALID == 0 && self.cob & IDENTIFIER != 0 && !self.mapped.is_empty()
    }

    /// Its identifier, if it is used.
    ///
    /// # Errors
    /// With the sub-index and a readable message, if it is used and has no identifier, or a reserved transmission type.
    pub(super) fn usable(&self) -> Result<Option<Id>, (u8, String)> {
        if !self.is_used() {
            return Ok(None);
        }
        let cob = self.cob;
        let id = id(cob).ok_or_else(|| {
            (1, format!("is {cob:#x}, which is no identifier: 11 bits, or 29 bits with bit 29 set"))
        })?;
        if RESERVED.contains(&self.kind.into()) {
            return Err((2, format!("is {}, a reserved transmission type", self.kind)));
        }
        Ok(Some(id))
    }

    /// The object with its parameters.
    pub(super) const fn object(&self, direction: Direction) -> u16 {
        direction.objects().0 + self.number - 1
    }

    pub(super) const fn allows_remote(&self) -> bool {
        self.cob & NO_RTR == 0
    }

    pub(super) fn length(&self) -> usize {
        let bits: u32 = self.mapped.iter().map(|mapped| mapped.bits).sum();
        bits.div_ceil(8) as usize
    }

    /// The objects in it, each with its first bit.
    pub(super) fn objects(&self) -> impl Iterator<Item = (usize, u32, u32)> {
        let mut begin = 0;
        let each = self.mapped.iter().map(move |mapped| {
            let first = begin;
            begin += mapped.bits;
            (mapped.entry, first, mapped.bits)
        });
        each.filter_map(|(entry, first, bits)| Some((entry?, first, bits)))
    }
}
