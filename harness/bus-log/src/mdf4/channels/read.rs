//! Reads a file of measured channels.

use super::super::super::Format;
use super::super::super::error::LogError;
use super::super::blocks::{Input, Source};
use super::contents::{self, Group};
use super::records::{PARTS_MAX, Records};
use super::values::{Cell, Values};
use std::io::SeekFrom;
use std::path::Path;

/// A file with measured channels. Only the descriptions of its groups and channels are in memory.
#[derive(Debug)]
pub struct Reader<'s> {
    source: Source<'s>,
    groups: Vec<Group>,
    is_unfinished: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wanted {
    pub channel: usize,
    /// Whether to read texts: those that its numbers stand for, if any.
    pub as_text: bool,
}

#[derive(Debug)]
#[must_use]
pub struct Found {
    pub records: u64,
    /// What ended the data of an unfinished file, if they do not end with a record.
    pub ended: Option<LogError>,
}

impl<'s> Reader<'s> {
    /// Reads from `input`; errors name `path`.
    ///
    /// # Errors
    /// When it is not such a file, or when the descriptions of its groups are damaged.
    pub fn new(path: &Path, mut input: impl Input + 's) -> Result<Self, LogError> {
        if input.seek(SeekFrom::End(0)).is_ok_and(|length| length == 0) {
            return Err(LogError::Empty { path: path.to_owned(), format: Format::Mdf4 });
        }
        let _ = input.rewind();
        let (mut source, header, is_unfinished) = Source::open(path, input)?;
        let groups = contents::all(&mut source, header.link(0))?;
        Ok(Self { source, groups, is_unfinished })
    }

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
        let mut values = Vec::new();
        // The parts that have something wanted, and the first, which has the times.
        let mut parts = vec![0];
        for Wanted { channel, as_text } in wanted {
            let Some(channel) = group.channels.get(*channel) else { continue };
            let Some(part) = group.parts.get(channel.part) else { continue };
            let bytes = (part.value_bytes, part.invalid_bytes);
            let value = Values::of(source, channel.address, bytes, *as_text, *is_unfinished)?;
            let place = parts.iter().position(|part| *part == channel.part).unwrap_or_else(|| {
                parts.push(channel.part);
                parts.len() - 1
            });
            values.push((place, value));
        }
        let parts: Vec<_> = parts.into_iter().filter_map(|part| group.parts.get(part)).collect();
        let address = parts.first().map_or(0, |part| part.address);
        if parts.len() > PARTS_MAX {
            let found = parts.len().to_string();
            return Ok(source.bad(address, "at most 1024 columns at once", found)?);
        }
        let records = parts.into_iter().map(|part| Records::of(part, source, *is_unfinished));
        let mut records: Vec<Records> = records.collect::<Result<_, _>>()?;
        let mut count = 0;
        loop {
            let next = records.iter_mut().map(|part| part.next(source));
            let record: Vec<Vec<u8>> = match next.collect::<Result<Option<_>, _>>() {
                Ok(Some(record)) => record,
                Ok(None) => break,
                Err(error @ LogError::Malformed { .. }) if *is_unfinished => {
                    return Ok(Found { records: count, ended: Some(error) });
                }
                Err(error) => return Err(error.into()),
            };
            let cells =
                values.iter_mut().map(|(place, value)| value.cell(&record[*place], count, source));
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
            source.bad(address, "as many records as the group says", found)?;
        }
        Ok(Found { records: count, ended: None })
    }
}
