//! Reads CAN frames with values precomputed per message.

use super::message::Message;
use super::number::{Coding, Scale};
use super::selection::Selection;
use super::signal::{Signal, Storage};
use crate::file::ByteOrder;
use wire::can::{DATA_BYTES_MAX, Id};
use wire::j1939::Identifier;

/// Number of 11-bit identifiers.
const STANDARD_IDS: usize = 1 << 11;

/// Stands for no message. No layout has as many: its file would have gigabytes.
const NONE: u32 = u32::MAX;

#[derive(Debug, Clone, Default)]
pub(super) struct Identifiers {
    /// One entry per identifier, [`NONE`] without a message. Empty if no message has an 11-bit identifier.
    standard: Box<[u32]>,
    /// In ascending order.
    extended: Box<[(u32, u32)]>,
    /// Parameter groups of J1939 carried by one frame: matched by their fields, since other nodes may send them too.
    groups: Box<[(Identifier, u32)]>,
}

impl Identifiers {
    pub(super) fn of(messages: &[Message]) -> Self {
        let mut standard = Vec::new();
        let mut extended = Vec::new();
        let mut groups = Vec::new();
        for (index, message) in (0..).zip(messages) {
            if message.is_in_parts() {
                continue;
            }
            groups.extend(message.group().map(|group| (group, index)));
            match message.can_id() {
                Some(Id::Standard(id)) => {
                    standard.resize(STANDARD_IDS, NONE);
                    standard[usize::from(id.as_raw())] = index;
                }
                Some(Id::Extended(id)) => extended.push((id.as_raw(), index)),
                None => {}
            }
        }
        extended.sort_unstable();
        Self { standard: standard.into(), extended: extended.into(), groups: groups.into() }
    }

    pub(super) fn find(&self, id: Id) -> Option<usize> {
        let place = match id {
            Id::Standard(id) => *self.standard.get(usize::from(id.as_raw()))?,
            Id::Extended(id) => {
                match self.extended.binary_search_by_key(&id.as_raw(), |(id, _)| *id) {
                    Ok(place) => self.extended[place].1,
                    Err(_) => {
                        let heard = Identifier::from(id);
                        self.groups.iter().find(|(group, _)| group.means(heard))?.1
                    }
                }
            }
        };
        (place != NONE).then_some(place as usize)
    }
}

/// A signal prepared for reading: some bits of the eight bytes as one number.
#[derive(Debug, Clone)]
struct Field {
    order: ByteOrder,
    /// Left shift that removes the bits above the field.
    left: u32,
    /// Right shift that then removes the bits below it.
    right: u32,
    coding: Coding,
    scale: Scale,
    when: Option<Selection>,
}

/// The bytes of a frame as one number in each byte order.
struct Words {
    little: u64,
    big: u64,
}

impl Field {
    /// `None` for a signal outside the frame's bytes.
    fn of(signal: &Signal) -> Option<Self> {
        let Storage::Bits { field, coding } = signal.storage else { return None };
        let right = u64::BITS - field.length();
        Some(Self {
            order: field.order(),
            left: right - field.shift_in_word()?,
            right,
            coding,
            scale: signal.scale,
            when: signal.carried.selection().cloned(),
        })
    }

    /// Its bits at the upper end of a number.
    #[inline]
    const fn upper(&self, words: &Words) -> u64 {
        match self.order {
            ByteOrder::Little => words.little << self.left,
            ByteOrder::Big => words.big << self.left,
        }
    }

    #[inline]
    fn value(&self, words: &Words) -> f64 {
        let upper = self.upper(words);
        let number = match self.coding {
            Coding::Signed => (upper as i64 >> self.right) as f64,
            // One instruction, which does not work for numbers of all 64 bits.
            Coding::Unsigned if self.right > 0 => (upper >> self.right) as i64 as f64,
            Coding::Unsigned => upper as f64,
            Coding::Float32 => f64::from(f32::from_bits((upper >> self.right) as u32)),
            Coding::Float64 => f64::from_bits(upper),
        };
        self.scale.physical(number)
    }
}

/// The signals of a CAN message; `None` if one lies beyond the eighth byte.
#[derive(Debug, Clone, Default)]
pub(super) struct FrameReader {
    fields: Option<Box<[Field]>>,
}

impl FrameReader {
    pub(super) fn of(message: &Message) -> Self {
        let fields: Option<Vec<Field>> = message.signals.iter().map(Field::of).collect();
        Self { fields: fields.map(Vec::into) }
    }

    /// Stores the values of a frame with these bytes in `values`, one per signal.
    #[inline]
    pub(super) fn read(&self, message: &Message, data: &[u8], values: &mut Vec<Option<f64>>) {
        let Some(fields) = &self.fields else { return message.read(data, values) };
        let bytes = data.first_chunk().copied().unwrap_or_else(|| {
            let mut bytes = [0; DATA_BYTES_MAX];
            bytes[..data.len()].copy_from_slice(data);
            bytes
        });
        let words = Words { little: u64::from_le_bytes(bytes), big: u64::from_be_bytes(bytes) };
        values.clear();
        values.extend(fields.iter().map(|field| match &field.when {
            Some(selection) if !selected(fields, selection, &words) => None,
            _ => Some(field.value(&words)),
        }));
    }
}

fn selected(fields: &[Field], selection: &Selection, words: &Words) -> bool {
    let multiplexer = &fields[selection.multiplexer];
    selection.has(multiplexer.upper(words) >> multiplexer.right)
        && multiplexer.when.as_ref().is_none_or(|above| selected(fields, above, words))
}
