//! The records of a group, or of some of its channels, in order.

use super::super::super::BUFFER_BYTES;
use super::super::super::error::{Defect, LogError};
use super::super::blocks::Source;
use super::super::buffered::Buffered;
use super::super::chain::{Chain, Content};
use super::contents::Part;
use std::io::{Read, Seek};

/// Most parts of a group that are read at once: each has its own buffer.
pub(super) const PARTS_MAX: usize = 1024;

pub(super) struct Records<'a> {
    data: Buffered,
    /// Invalidation bits that are stored by themselves, and their bytes in a record.
    invalid: Option<(Buffered, usize)>,
    part: &'a Part,
    /// Length of a record, without these.
    length: usize,
}

impl<'a> Records<'a> {
    pub(super) fn of<R: Read + Seek>(
        part: &'a Part,
        source: &mut Source<R>,
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
            let defect = Defect::new("records of 1 to 65536 bytes", found.as_bytes());
            return Err(source.malformed(part.address, defect));
        }
        let of = |content| Buffered::new(Chain::of(content, part.data, unfinished));
        let invalid = (apart && bits > 0).then(|| (of(Content::Invalidation), bits));
        let data = of(if apart { Content::Values } else { Content::Whole });
        Ok(Self { data, invalid, part, length })
    }

    /// Returns the next record of the group; `None` at the end.
    pub(super) fn next<R: Read + Seek>(
        &mut self,
        source: &mut Source<R>,
    ) -> Result<Option<Vec<u8>>, LogError> {
        loop {
            if !self.data.has(1, source)? {
                return Ok(None);
            }
            let number_bytes = self.part.number_bytes;
            if !self.data.has(number_bytes, source)? {
                return Err(self.cut(source));
            }
            let number = self.data.number(number_bytes);
            self.skip(number_bytes as u64, source)?;
            if number_bytes == 0 || number == self.part.number {
                if !self.data.has(self.length, source)? {
                    return Err(self.cut(source));
                }
                let mut record = self.data.bytes()[..self.length].to_vec();
                self.skip(self.length as u64, source)?;
                self.invalidation(source, &mut record)?;
                return Ok(Some(record));
            }
            let others = &self.part.others;
            let Ok(place) = others.binary_search_by_key(&number, |(other, _)| *other) else {
                let expected = "the number of a group before a record";
                let defect = Defect::new(expected, number.to_string().as_bytes());
                return Err(source.malformed(self.data.began(), defect));
            };
            let length = match others[place].1 {
                Some(length) => length,
                None if self.data.has(4, source)? => {
                    let bytes = self.data.bytes().first_chunk().copied();
                    4 + bytes.map_or(0, |bytes| u64::from(u32::from_le_bytes(bytes)))
                }
                None => return Err(self.cut(source)),
            };
            self.skip(length, source)?;
        }
    }

    /// Appends the invalidation bits that are stored by themselves; without any, all values are valid.
    fn invalidation<R: Read + Seek>(
        &mut self,
        source: &mut Source<R>,
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

    fn skip<R: Read + Seek>(&mut self, count: u64, source: &mut Source<R>) -> Result<(), LogError> {
        match self.data.skip(count, source)? {
            true => Ok(()),
            false => Err(self.cut(source)),
        }
    }

    fn cut<R: Read + Seek>(&self, source: &Source<R>) -> LogError {
        let defect = Defect::new("a whole record", b"the end of the data").cut();
        source.malformed(self.data.began(), defect)
    }
}
