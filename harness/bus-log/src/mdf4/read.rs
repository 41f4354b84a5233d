//! Reads an MDF file.

use super::super::entry::Entry;
use super::super::error::{Defect, LogError};
use super::blocks::Source;
use super::stream::Stream;
use super::{FILE_MARK, IDENTIFICATION_BYTES, UNFINISHED_MARK, groups};
use std::io::{Read, Seek};
use std::path::Path;

/// What may be unfinished in a file and does not matter here: counts of records, the length of the last data block, and
/// the bytes of a group of variable length.
const UNFINISHED: u16 = 0x2f;

/// The entries of an MDF file. It has as many buffers as there are data groups with frames.
#[derive(Debug)]
pub(crate) struct Reader<R: Read + Seek> {
    source: Source<R>,
    streams: Vec<Stream>,
    /// The next entry of each; none of one that has no more.
    heads: Vec<Option<Entry>>,
    /// The streams whose next entry is not known.
    unknown: Vec<usize>,
}

impl<R: Read + Seek> Reader<R> {
    /// Reads from `input`; `path` is named in errors.
    ///
    /// # Errors
    /// When it does not begin as such a file does.
    pub(crate) fn new(path: &Path, input: R) -> Result<Self, LogError> {
        let mut source = Source::new(path, input)?;
        let mut head = [0; IDENTIFICATION_BYTES];
        source.at(0, &mut head)?;
        let is_finished = head.starts_with(FILE_MARK);
        let version = u16::from_le_bytes([head[28], head[29]]);
        let unfinished = u16::from_le_bytes([head[60], head[61]]);
        let bad = |expected, found: &str| {
            Err(source.malformed(0, Defect::new(expected, found.as_bytes())))
        };
        if !is_finished && !head.starts_with(UNFINISHED_MARK) {
            return bad("`MDF` and its version", &String::from_utf8_lossy(&head[..8]));
        }
        if !(400..500).contains(&version) {
            return bad("version 4 of MDF", &format!("version {version}"));
        }
        if !is_finished && unfinished & !UNFINISHED != 0 {
            return bad("a file that its logger finished", &format!("flags {unfinished:#06x}"));
        }
        let header = source.block(IDENTIFICATION_BYTES as u64, "##HD")?;
        let Ok(began) = i64::try_from(header.u64(0)) else {
            let defect = Defect::new("a begin before 2262", header.u64(0).to_string().as_bytes());
            return Err(source.malformed(header.address, defect));
        };
        let groups = groups::all(&mut source, header.link(0))?;
        let streams: Vec<_> =
            groups.into_iter().map(|group| Stream::new(group, began, !is_finished)).collect();
        let heads = streams.iter().map(|_| None).collect();
        let unknown = (0..streams.len()).collect();
        Ok(Self { source, streams, heads, unknown })
    }

    /// Records so far that are no frames, in groups that have frames, too.
    pub(crate) fn passed_over(&self) -> u64 {
        self.streams.iter().map(Stream::passed_over).sum()
    }

    /// The next entry; none at the end.
    pub(crate) fn read(&mut self) -> Result<Option<Entry>, LogError> {
        for index in self.unknown.drain(..) {
            self.heads[index] = self.streams[index].next(&mut self.source)?;
        }
        let times = self.heads.iter().enumerate();
        let times = times.filter_map(|(index, head)| head.map(|head| (head.at, index)));
        let Some((_, index)) = times.min() else { return Ok(None) };
        self.unknown.push(index);
        Ok(self.heads[index].take())
    }
}
