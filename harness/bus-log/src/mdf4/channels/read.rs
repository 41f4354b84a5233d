//! Reads a file of measured channels.

use super::super::super::BUFFER_BYTES;
use super::super::super::error::{Defect, LogError};
use super::super::super::window::Window;
use super::super::blocks::Source;
use super::super::chain::Chain;
use super::super::opening::{Opened, open};
use super::contents::{self, Group};
use super::values::{Cell, Values};
use std::io::{Read, Seek};
use std::path::Path;

/// A file with measured channels. Only the descriptions of its groups and channels are in memory.
#[derive(Debug)]
pub struct Reader<R: Read + Seek> {
    source: Source<R>,
    groups: Vec<Group>,
    is_unfinished: bool,
}

/// A requested channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wanted {
    /// Index in its group.
    pub channel: usize,
    /// Whether to read texts: those that its numbers stand for, if any.
    pub as_text: bool,
}

/// Result of reading a group.
#[derive(Debug)]
#[must_use]
pub struct Found {
    /// Number of records.
    pub records: u64,
    /// What ended the data of an unfinished file, if they do not end with a record.
    pub ended: Option<LogError>,
}

/// The records of one group, in order.
struct Records<'a> {
    chain: Chain,
    window: Window,
    group: &'a Group,
    /// Length of a record.
    length: usize,
}

impl<R: Read + Seek> Reader<R> {
    /// Reads from `input`; errors name `path`.
    ///
    /// # Errors
    /// When it is not such a file, or when the descriptions of its groups are damaged.
    pub fn new(path: &Path, input: R) -> Result<Self, LogError> {
        let mut source = Source::new(path, input)?;
        let Opened { is_unfinished, header } = open(&mut source)?;
        let groups = contents::all(&mut source, header.link(0))?;
        Ok(Self { source, groups, is_unfinished })
    }

    /// Its groups, in order.
    pub fn groups(&self) -> &[Group] {
        &self.groups
    }

    /// Whether the file was not finished by its writer. It is read as far as it goes.
    pub const fn is_unfinished(&self) -> bool {
        self.is_unfinished
    }

    /// Passes the values of each record of a group to `each`, one per wanted channel, in the order of the file.
    ///
    /// When the file cannot be read, is damaged or ends too early, with the block; when a channel cannot be read: an
    /// array, algebra, a text where a number is wanted. An early end of an unfinished file is not an error. Errors of
    /// `each`.
    pub fn read<E: From<LogError>>(
        &mut self,
        group: usize,
        wanted: &[Wanted],
        each: &mut dyn FnMut(Vec<Cell>) -> Result<(), E>,
    ) -> Result<Found, E> {
        let Self { source, groups, is_unfinished } = self;
        let Some(group) = groups.get(group) else {
            return Ok(Found { records: 0, ended: None });
        };
        let bytes = (group.value_bytes, group.invalid_bytes);
        let mut values = Vec::new();
        for Wanted { channel, as_text } in wanted {
            let Some(channel) = group.channels.get(*channel) else { continue };
            values.push(Values::of(source, channel.address, bytes, *as_text, *is_unfinished)?);
        }
        let mut records = Records::of(group, source, *is_unfinished)?;
        let mut count = 0;
        loop {
            let record = match records.next(source) {
                Ok(Some(record)) => record,
                Ok(None) => break,
                Err(error @ LogError::Malformed { .. }) if *is_unfinished => {
                    return Ok(Found { records: count, ended: Some(error) });
                }
                Err(error) => return Err(error.into()),
            };
            let cells = values.iter_mut().map(|value| value.cell(&record, count, source));
            let cells = match cells.collect() {
                Ok(cells) => cells,
                // Texts that were not written any more.
                Err(error @ LogError::Malformed { .. }) if *is_unfinished => {
                    return Ok(Found { records: count, ended: Some(error) });
                }
                Err(error) => return Err(error.into()),
            };
            each(cells)?;
            count += 1;
        }
        if !*is_unfinished && count != group.records {
            let found = format!("{count} of {}", group.records);
            let defect = Defect::new("as many records as the group says", found.as_bytes());
            return Err(source.malformed(group.address, defect).into());
        }
        Ok(Found { records: count, ended: None })
    }
}

impl<'a> Records<'a> {
    fn of<R: Read + Seek>(
        group: &'a Group,
        source: &Source<R>,
        unfinished: bool,
    ) -> Result<Self, LogError> {
        let bytes = group.value_bytes + group.invalid_bytes;
        let length = usize::try_from(bytes).unwrap_or(usize::MAX);
        // Records without bytes would never end.
        if length > BUFFER_BYTES || length + group.number_bytes == 0 {
            let found = format!("{bytes} bytes");
            let defect = Defect::new("records of 1 to 65536 bytes", found.as_bytes());
            return Err(source.malformed(group.address, defect));
        }
        let (chain, window) = (Chain::new(group.data, unfinished), Window::new());
        Ok(Self { chain, window, group, length })
    }

    /// Returns the next record of the group; `None` at the end.
    fn next<R: Read + Seek>(
        &mut self,
        source: &mut Source<R>,
    ) -> Result<Option<Vec<u8>>, LogError> {
        loop {
            if !self.has(1, source)? {
                return Ok(None);
            }
            let number_bytes = self.group.number_bytes;
            if !self.has(number_bytes, source)? {
                return Err(self.cut(source));
            }
            let bytes = self.window.bytes().iter().take(number_bytes);
            let number = bytes.rev().fold(0, |number, byte| number << 8 | u64::from(*byte));
            self.skip(number_bytes as u64, source)?;
            if number_bytes == 0 || number == self.group.number {
                if !self.has(self.length, source)? {
                    return Err(self.cut(source));
                }
                let record = self.window.bytes()[..self.length].to_vec();
                self.skip(self.length as u64, source)?;
                return Ok(Some(record));
            }
            let others = &self.group.others;
            let Ok(place) = others.binary_search_by_key(&number, |(other, _)| *other) else {
                let expected = "the number of a group before a record";
                let defect = Defect::new(expected, number.to_string().as_bytes());
                return Err(source.malformed(self.chain.began(), defect));
            };
            let length = match others[place].1 {
                Some(length) => length,
                None if self.has(4, source)? => {
                    let bytes = self.window.bytes().first_chunk().copied();
                    4 + bytes.map_or(0, |bytes| u64::from(u32::from_le_bytes(bytes)))
                }
                None => return Err(self.cut(source)),
            };
            self.skip(length, source)?;
        }
    }

    fn has<R: Read + Seek>(
        &mut self,
        count: usize,
        source: &mut Source<R>,
    ) -> Result<bool, LogError> {
        self.window.has(count, |out| self.chain.read(source, out))
    }

    fn skip<R: Read + Seek>(&mut self, count: u64, source: &mut Source<R>) -> Result<(), LogError> {
        match self.window.skip(count, |out| self.chain.read(source, out))? {
            true => Ok(()),
            false => Err(self.cut(source)),
        }
    }

    fn cut<R: Read + Seek>(&self, source: &Source<R>) -> LogError {
        let defect = Defect::new("a whole record", b"the end of the data");
        source.malformed(self.chain.began(), defect)
    }
}
