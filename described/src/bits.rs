//! Position of a signal's bits in the bytes of its message.

use described_file::ByteOrder;
use std::ops::RangeInclusive;

/// Maximum number of bits in a signal.
pub const SIGNAL_BITS_MAX: u32 = 64;

/// A signal of [`SIGNAL_BITS_MAX`] bits that starts within a byte touches nine bytes: a window of sixteen holds all of
/// them.
const WINDOW_BYTES: usize = 16;
const WINDOW_BITS: u32 = 8 * WINDOW_BYTES as u32;

/// Consecutive bits of a message, numbered as in a DBC: bit `8 * byte + weight`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct BitField {
    order: ByteOrder,
    /// Little-endian: the least significant bit. Big-endian: the most significant bit.
    start: usize,
    /// From 1 to [`SIGNAL_BITS_MAX`].
    length: u32,
}

impl BitField {
    /// `None` if there are no bits, too many, or some outside of `bytes` bytes.
    pub(crate) fn new(order: ByteOrder, start: u64, length: u64, bytes: usize) -> Option<Self> {
        let start = usize::try_from(start).ok().filter(|start| *start < 8 * bytes)?;
        let length = u32::try_from(length).ok().filter(|n| (1..=SIGNAL_BITS_MAX).contains(n))?;
        let room = match order {
            ByteOrder::Little => 8 * bytes - start,
            ByteOrder::Big => 8 * (bytes - start / 8) - (7 - start % 8),
        };
        (length as usize <= room).then_some(Self { order, start, length })
    }

    pub(crate) const fn length(self) -> u32 {
        self.length
    }

    /// The bits as a number. Bytes missing in `data` read as zero.
    pub(crate) fn get(self, data: &[u8]) -> u64 {
        ((self.load(data) >> self.shift()) as u64) & self.mask()
    }

    /// Replaces the bits by the lowest bits of `raw`.
    pub(crate) fn set(self, data: &mut [u8], raw: u64) {
        let place = u128::from(self.mask()) << self.shift();
        let bits = u128::from(raw & self.mask()) << self.shift();
        let window = (self.load(data) & !place) | bits;
        let bytes = match self.order {
            ByteOrder::Little => window.to_le_bytes(),
            ByteOrder::Big => window.to_be_bytes(),
        };
        for (byte, new) in data.iter_mut().skip(self.start / 8).zip(bytes) {
            *byte = new;
        }
    }

    /// True if both have a bit in common.
    pub(crate) fn overlaps(self, other: Self) -> bool {
        let (ours, theirs) = (self.bytes(), other.bytes());
        let is_near = ours.start() <= theirs.end() && theirs.start() <= ours.end();
        is_near && self.bits().any(|bit| other.bits().any(|taken| taken == bit))
    }

    /// The bytes that it touches.
    pub(crate) fn bytes(self) -> RangeInclusive<usize> {
        let ahead = match self.order {
            ByteOrder::Little => self.start % 8,
            ByteOrder::Big => 7 - self.start % 8,
        };
        let first = self.start / 8;
        first..=first + (ahead + self.length as usize - 1) / 8
    }

    pub(super) const fn order(self) -> ByteOrder {
        self.order
    }

    /// Distance of its lowest bit from the lowest bit of the first eight bytes, taken as one number in its byte order;
    /// `None` if it extends beyond them.
    pub(super) fn shift_in_word(self) -> Option<u32> {
        let start = self.start as u32;
        match self.order {
            ByteOrder::Little => (start + self.length <= u64::BITS).then_some(start),
            ByteOrder::Big => {
                // The last transmitted bit is the lowest one.
                let end = 8 * (start / 8) + (7 - start % 8) + self.length;
                u64::BITS.checked_sub(end)
            }
        }
    }

    /// The field in a message without its first `bytes` bytes, none of which it touches.
    pub(crate) const fn behind(self, bytes: usize) -> Self {
        Self { start: self.start.saturating_sub(8 * bytes), ..self }
    }

    /// True if both have each bit at the same position. Within one byte the byte order does not matter.
    pub(crate) fn is_same(self, other: Self) -> bool {
        let lowest_first = |field: Self| {
            let mut bits: Vec<usize> = field.bits().collect();
            if field.order == ByteOrder::Big {
                bits.reverse();
            }
            bits
        };
        lowest_first(self) == lowest_first(other)
    }

    /// The number of each bit, along the field.
    pub(crate) fn bits(self) -> impl Iterator<Item = usize> {
        (0..self.length as usize).map(move |index| match self.order {
            ByteOrder::Little => self.start + index,
            ByteOrder::Big => {
                // Counted in transmission order, with the most significant bit of each byte first.
                let along = 8 * (self.start / 8) + (7 - self.start % 8) + index;
                8 * (along / 8) + (7 - along % 8)
            }
        })
    }

    /// True if it has room for the number.
    pub(super) const fn reaches(self, number: u64) -> bool {
        number <= self.mask()
    }

    const fn mask(self) -> u64 {
        u64::MAX >> (SIGNAL_BITS_MAX - self.length)
    }

    /// Distance between the lowest bits of window and field.
    const fn shift(self) -> u32 {
        let within_byte = (self.start % 8) as u32;
        match self.order {
            ByteOrder::Little => within_byte,
            ByteOrder::Big => WINDOW_BITS - 8 + within_byte + 1 - self.length,
        }
    }

    fn load(self, data: &[u8]) -> u128 {
        let mut window = [0; WINDOW_BYTES];
        for (byte, from) in window.iter_mut().zip(data.iter().skip(self.start / 8)) {
            *byte = *from;
        }
        match self.order {
            ByteOrder::Little => u128::from_le_bytes(window),
            ByteOrder::Big => u128::from_be_bytes(window),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{BitField, ByteOrder};
    use proptest::prelude::*;

    const BYTES: usize = 8;

    fn any_order() -> impl Strategy<Value = ByteOrder> {
        prop_oneof![Just(ByteOrder::Little), Just(ByteOrder::Big)]
    }

    fn any_field() -> impl Strategy<Value = BitField> {
        (any_order(), 0u64..64, 1u64..=64).prop_filter_map("inside", |(order, start, length)| {
            BitField::new(order, start, length, BYTES)
        })
    }

    #[test]
    fn the_textbook_case_of_either_order() {
        let mut data = [0; 3];
        BitField::new(ByteOrder::Little, 4, 12, 3).unwrap().set(&mut data, 0xabc);
        assert_eq!(data, [0xc0, 0xab, 0]);
        let mut data = [0; 3];
        BitField::new(ByteOrder::Big, 3, 12, 3).unwrap().set(&mut data, 0xabc);
        assert_eq!(data, [0x0a, 0xbc, 0]);
    }

    #[test]
    fn what_does_not_lie_inside_is_no_field() {
        assert!(BitField::new(ByteOrder::Little, 56, 8, BYTES).is_some());
        assert!(BitField::new(ByteOrder::Little, 57, 8, BYTES).is_none());
        assert!(BitField::new(ByteOrder::Big, 63, 8, BYTES).is_some());
        assert!(BitField::new(ByteOrder::Big, 62, 8, BYTES).is_none());
        assert!(BitField::new(ByteOrder::Big, 64, 1, BYTES).is_none());
        assert!(BitField::new(ByteOrder::Little, 0, 0, BYTES).is_none());
        assert!(BitField::new(ByteOrder::Little, 0, 65, 16).is_none());
        assert!(BitField::new(ByteOrder::Little, u64::MAX, u64::MAX, BYTES).is_none());
    }

    proptest! {
        /// The window agrees with the definition, bit by bit.
        #[test]
        fn each_bit_is_where_its_number_says(field in any_field(), data in any::<[u8; BYTES]>()) {
            let bit = |number: usize| u64::from(data[number / 8] >> (number % 8)) & 1;
            let along: Vec<u64> = field.bits().map(bit).collect();
            let fold = |raw: u64, bit: &u64| raw << 1 | bit;
            let raw = match field.order {
                ByteOrder::Little => along.iter().rev().fold(0, fold),
                ByteOrder::Big => along.iter().fold(0, fold),
            };
            prop_assert_eq!(field.get(&data), raw);
        }

        #[test]
        fn what_is_set_is_got_and_the_rest_stays(
            field in any_field(), other in any_field(), raw in any::<u64>(), data in any::<[u8; BYTES]>()
        ) {
            let mut changed = data;
            field.set(&mut changed, raw);
            prop_assert_eq!(field.get(&changed), raw & field.mask());
            if !field.overlaps(other) {
                prop_assert_eq!(other.get(&changed), other.get(&data));
            }
            field.set(&mut changed, field.get(&data));
            prop_assert_eq!(changed, data);
        }
    }
}
