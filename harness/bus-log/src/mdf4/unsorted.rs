//! The records of a data group, whose groups may share it, in the order of the file.

use super::super::error::{Defect, LogError};
use super::CG_VARIABLE;
use super::blocks::{Block, Source};
use super::buffered::Buffered;
use super::chain::Chain;
use std::sync::Arc;

/// Numbers of the groups in ascending order, each with the length of its records, bytes; none if the records state it.
pub(super) type Lengths = Arc<[(u64, Option<u64>)]>;

/// The lengths of records of these groups. Of groups with one number the first one counts.
pub(super) fn lengths(groups: &[Block]) -> Lengths {
    let length = |group: &Block| {
        let bytes = u64::from(group.u32(24)) + u64::from(group.u32(28));
        (group.u64(0), (!is_variable(group)).then_some(bytes))
    };
    let mut lengths: Vec<_> = groups.iter().map(length).collect();
    lengths.sort_by_key(|(number, _)| *number);
    lengths.dedup_by_key(|(number, _)| *number);
    lengths.into()
}

/// Whether records of that group are data to which other records refer.
pub(super) fn is_variable(group: &Block) -> bool {
    group.u16(16) & CG_VARIABLE != 0
}

#[derive(Debug)]
pub(super) struct Unsorted {
    data: Buffered,
    /// Length of the record number before each record.
    number_bytes: usize,
    lengths: Lengths,
}

impl Unsorted {
    pub(super) fn new(data: Chain, number_bytes: usize, lengths: Lengths) -> Self {
        Self { data: Buffered::new(data), number_bytes, lengths }
    }

    /// Advances to the next record, which is to be taken or skipped then: the index of its group among the lengths, and
    /// its length. `None` at the end.
    pub(super) fn next(
        &mut self,
        source: &mut Source<'_>,
    ) -> Result<Option<(usize, u64)>, LogError> {
        if !self.data.has(self.number_bytes.max(1), source)? {
            return if self.data.bytes().is_empty() { Ok(None) } else { Err(self.cut(source)) };
        }
        let number = self.data.number(self.number_bytes);
        let index = match self.number_bytes {
            // There is one group.
            0 => Ok(0),
            _ => self.lengths.binary_search_by_key(&number, |(other, _)| *other),
        };
        let Ok(index) = index else {
            let expected = "the number of a group before a record";
            return source.bad(self.data.began(), expected, number.to_string());
        };
        self.skip(self.number_bytes as u64, source)?;
        let length = match self.lengths[index].1 {
            Some(length) => length,
            None if self.data.has(4, source)? => {
                let length = self.data.number(4);
                self.skip(4, source)?;
                length
            }
            None => return Err(self.cut(source)),
        };
        Ok(Some((index, length)))
    }

    /// Takes a record of that length; returns at most its first `most` bytes, for which a window has room.
    pub(super) fn take(
        &mut self,
        length: u64,
        most: usize,
        source: &mut Source<'_>,
    ) -> Result<Vec<u8>, LogError> {
        let known = length.min(most as u64) as usize;
        if !self.data.has(known, source)? {
            return Err(self.cut(source));
        }
        let bytes = self.data.bytes()[..known].to_vec();
        self.skip(length, source).map(|()| bytes)
    }

    pub(super) fn skip(&mut self, count: u64, source: &mut Source<'_>) -> Result<(), LogError> {
        if self.data.skip(count, source)? { Ok(()) } else { Err(self.cut(source)) }
    }

    fn cut(&self, source: &Source<'_>) -> LogError {
        self.malformed(Defect::new("a whole record", b"the end of the data").cut(), source)
    }

    /// The error of a record in the current block.
    pub(super) fn malformed(&self, defect: Defect, source: &Source<'_>) -> LogError {
        source.malformed(self.data.began(), defect)
    }
}
