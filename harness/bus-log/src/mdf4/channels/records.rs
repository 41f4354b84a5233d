//! The records of a group, or of some of its channels, in order.

use super::super::super::BUFFER_BYTES;
use super::super::super::error::LogError;
use super::super::blocks::Source;
use super::super::buffered::Buffered;
use super::super::chain::{Chain, Content};
use super::super::unsorted::Unsorted;
use super::contents::Part;
use std::sync::Arc;

/// Most parts of a group that are read at once: each has its own buffer.
pub(super) const PARTS_MAX: usize = 1024;

pub(super) struct Records {
    data: Unsorted,
    /// Invalidation bits that are stored by themselves, and their bytes in a record.
    invalid: Option<(Buffered, usize)>,
    /// Index of the own group among those of the data.
    own: usize,
    /// Length of a record, without these.
    length: usize,
}

impl Records {
    pub(super) fn of(
        part: &Part,
        source: &mut Source<'_>,
        unfinished: bool,
    ) -> Result<Self, LogError> {
        let bytes = |bytes| usize::try_from(bytes).unwrap_or(usize::MAX);
        let (values, bits) = (bytes(part.value_bytes), bytes(part.invalid_bytes));
        let apart = part.data != 0
            && part.number_bytes == 0
            && source.any_block(part.data)?.mark() == b"##LD";
        let length = if apart { values } else { values.saturating_add(bits) };
        // Records without bytes would never end.
        if length.max(bits) > BUFFER_BYTES || length + part.number_bytes == 0 {
            let found = format!("{length} bytes");
            return source.bad(part.address, "records of 1 to 65536 bytes", found);
        }
        let of = |content| Chain::of(content, part.data, unfinished);
        let invalid = (apart && bits > 0).then(|| (Buffered::new(of(Content::Invalidation)), bits));
        let data = of(if apart { Content::Values } else { Content::Whole });
        let data = Unsorted::new(data, part.number_bytes, Arc::clone(&part.lengths));
        let own = part.lengths.binary_search_by_key(&part.number, |(number, _)| *number);
        Ok(Self { data, invalid, own: own.unwrap_or(0), length })
    }

    /// Returns the next record of the group; `None` at the end.
    pub(super) fn next(&mut self, source: &mut Source<'_>) -> Result<Option<Vec<u8>>, LogError> {
        while let Some((index, length)) = self.data.next(source)? {
            if index == self.own {
                let mut record = self.data.take(self.length as u64, self.length, source)?;
                self.invalidation(source, &mut record)?;
                return Ok(Some(record));
            }
            self.data.skip(length, source)?;
        }
        Ok(None)
    }

    /// Appends the invalidation bits that are stored by themselves; without any, all values are valid.
    fn invalidation(
        &mut self,
        source: &mut Source<'_>,
        record: &mut Vec<u8>,
    ) -> Result<(), LogError> {
        let Some((bits, length)) = &mut self.invalid else { return Ok(()) };
        match bits.has(*length, source)? {
            true => record.extend_from_slice(&bits.bytes()[..*length]),
            false => record.resize(record.len() + *length, 0),
        }
        bits.skip(*length as u64, source)?;
        Ok(())
    }
}
