//! Reads an MDF file.

use super::super::ReadEntries;
use super::super::entry::Entry;
use super::super::error::LogError;
use super::blocks::{Input, Source};
use super::groups;
use super::lost;
use super::stream::Stream;
use std::path::Path;

/// The entries of an MDF file. It has one buffer per data group with frames.
#[derive(Debug)]
pub(crate) struct Reader<'s> {
    source: Source<'s>,
    streams: Vec<Stream>,
    /// Next entry of each stream; `None` at its end.
    heads: Vec<Option<Entry>>,
    /// Streams whose next entry is not read yet.
    unknown: Vec<usize>,
    /// Why a stream ended too early: told behind what the others have.
    cut: Option<LogError>,
}

impl<'s> Reader<'s> {
    /// Reads from `input`; errors name `path`.
    ///
    /// # Errors
    /// When the file does not begin like an MDF file.
    pub(crate) fn new(path: &Path, input: impl Input + 's) -> Result<Self, LogError> {
        let (mut source, header, is_unfinished) = Source::open(path, input)?;
        let Ok(began) = i64::try_from(header.u64(0)) else {
            return source.bad(header.address, "a begin before 2262", header.u64(0).to_string());
        };
        let (groups, has_others) = groups::all(&mut source, header.link(0))?;
        let chains = lost::chains(&mut source, (&groups, has_others), is_unfinished)?;
        let streams = groups.into_iter().zip(chains);
        let streams = streams.map(|(group, data)| Stream::new(data, group, began, is_unfinished));
        let streams: Vec<_> = streams.collect();
        let heads = streams.iter().map(|_| None).collect();
        let unknown = (0..streams.len()).collect();
        Ok(Self { source, streams, heads, unknown, cut: None })
    }
}

impl ReadEntries for Reader<'_> {
    fn read(&mut self) -> Result<Option<Entry>, LogError> {
        for index in self.unknown.drain(..) {
            match self.streams[index].next(&mut self.source) {
                Ok(head) => self.heads[index] = head,
                Err(error) if error.is_cut() => _ = self.cut.get_or_insert(error),
                Err(error) => return Err(error),
            }
        }
        let times = self.heads.iter().enumerate();
        let times = times.filter_map(|(index, head)| head.map(|head| (head.at, index)));
        let Some((_, index)) = times.min() else { return self.cut.take().map_or(Ok(None), Err) };
        self.unknown.push(index);
        Ok(self.heads[index].take())
    }

    /// Number of records so far that are not frames, including those in groups of frames.
    fn passed_over(&self) -> u64 {
        self.streams.iter().map(Stream::passed_over).sum()
    }
}
