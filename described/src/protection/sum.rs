//! A checksum among the signals of a message.

use super::catalogue::Checksum;
use crate::bits::BitField;
use std::ops::Range;

/// The checksum of a message in its own signal.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FrameSum {
    pub(crate) checksum: Checksum,
    /// As wide as the checksum.
    pub(crate) field: BitField,
    /// The covered bytes; `None` for all bytes without bits of the checksum. Covered bits of the checksum itself count
    /// as zero.
    pub(crate) covers: Option<Range<usize>>,
    /// Bytes before those of the message that are covered but not sent: a data id.
    pub(crate) before: Vec<u8>,
    /// Likewise after the message.
    pub(crate) behind: Vec<u8>,
}

impl FrameSum {
    pub(super) fn of(&self, data: &[u8]) -> u64 {
        let mut covered = self.before.clone();
        match &self.covers {
            Some(range) => {
                let mut blank = data.to_vec();
                self.field.set(&mut blank, 0);
                covered.extend_from_slice(blank.get(range.clone()).unwrap_or_default());
            }
            None => {
                let own = self.field.bytes();
                let others = data.iter().enumerate().filter(|(at, _)| !own.contains(at));
                covered.extend(others.map(|(_, byte)| *byte));
            }
        }
        covered.extend_from_slice(&self.behind);
        u64::from(self.checksum.value(&covered))
    }
}

#[cfg(test)]
mod tests {
    use super::{BitField, Checksum, FrameSum};
    use crate::file::ByteOrder;

    fn sum(start: u64, length: u64) -> FrameSum {
        FrameSum {
            checksum: Checksum::Sum8,
            field: BitField::new(ByteOrder::Little, start, length, 4).unwrap(),
            covers: None,
            before: Vec::new(),
            behind: Vec::new(),
        }
    }

    #[test]
    fn it_covers_all_bytes_but_its_own() {
        assert_eq!(sum(8, 8).of(&[1, 0x80, 4, 8]), 13);
        // Across two bytes: both belong to the checksum.
        assert_eq!(sum(4, 8).of(&[1, 0x80, 4, 8]), 12);
    }

    #[test]
    fn it_covers_what_is_said_and_its_own_bits_as_zero() {
        let said = FrameSum { covers: Some(0..3), ..sum(4, 8) };
        assert_eq!(said.of(&[0xf1, 0x8f, 4, 8]), 0x1 + 0x80 + 4);
        let with_id = FrameSum { before: vec![0x10], behind: vec![0x20], ..said };
        assert_eq!(with_id.of(&[0xf1, 0x8f, 4, 8]), 0x10 + 0x1 + 0x80 + 4 + 0x20);
    }
}
