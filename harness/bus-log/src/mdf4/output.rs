//! Writes data into a file as they come: compressed blocks, and lists of these.

use super::BLOCK_HEAD_BYTES;
use super::laid::push_block;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::fmt;
use std::io::{self, Seek, SeekFrom, Write};

const LIST_BLOCKS: usize = 64;
/// Flag of a list whose blocks, except the last, have equal length.
const EQUAL: u8 = 1;

/// Where a file is written.
pub trait Target: Write + Seek + fmt::Debug {}

impl<T: Write + Seek + fmt::Debug> Target for T {}

#[derive(Debug)]
pub(super) struct Output<'w> {
    out: Box<dyn Target + 'w>,
    /// Bytes written so far, always a multiple of eight.
    place: u64,
}

impl<'w> Output<'w> {
    pub(super) fn new(mut out: impl Target + 'w, begin: &[u8]) -> io::Result<Self> {
        out.write_all(begin)?;
        Ok(Self { out: Box::new(out), place: begin.len() as u64 })
    }

    /// Address of the next byte.
    pub(super) const fn place(&self) -> u64 {
        self.place
    }

    /// Appends bytes, a multiple of eight of them.
    pub(super) fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.out.write_all(bytes)?;
        self.place += bytes.len() as u64;
        Ok(())
    }

    pub(super) fn block(&mut self, mark: [u8; 4], links: &[u64], data: &[u8]) -> io::Result<u64> {
        let mut bytes = Vec::new();
        push_block(&mut bytes, mark, links, data);
        let place = self.place;
        self.append(&bytes)?;
        Ok(place)
    }

    /// Overwrites the bytes at `place`, and returns to the end.
    fn replace(&mut self, place: u64, bytes: &[u8]) -> io::Result<()> {
        self.out.seek(SeekFrom::Start(place))?;
        self.out.write_all(bytes)?;
        self.out.seek(SeekFrom::Start(self.place)).map(|_| ())
    }

    /// Overwrites the start, and flushes the file.
    pub(super) fn finish(mut self, begin: &[u8]) -> io::Result<()> {
        self.replace(0, begin)?;
        self.out.flush()
    }
}

/// Records, or signal data, being written.
#[derive(Debug)]
pub(super) struct Data {
    /// Kind of their block without compression.
    kind: [u8; 2],
    block_bytes: usize,
    /// Whether all blocks have exactly that length, because the records have equal length; otherwise at least that
    /// length.
    is_equal: bool,
    waiting: Vec<u8>,
    /// Bytes in blocks so far.
    written: u64,
    /// Blocks for the next list: address, and offset in the data.
    blocks: Vec<(u64, u64)>,
    /// Addresses of the first and last list; `None` before the first.
    lists: Option<(u64, u64)>,
}

impl Data {
    /// Records of one length, a whole number of them in `block_bytes`.
    pub(super) const fn records(block_bytes: usize) -> Self {
        Self::of(*b"DT", block_bytes, true)
    }

    /// Values of different lengths (`SD`).
    pub(super) const fn values(block_bytes: usize) -> Self {
        Self::of(*b"SD", block_bytes, false)
    }

    const fn of(kind: [u8; 2], block_bytes: usize, is_equal: bool) -> Self {
        Self {
            kind,
            block_bytes,
            is_equal,
            waiting: Vec::new(),
            written: 0,
            blocks: Vec::new(),
            lists: None,
        }
    }

    /// Length so far, which is the offset of the next item.
    pub(super) const fn length(&self) -> u64 {
        self.written + self.waiting.len() as u64
    }

    /// Appends a record or a value, as appended by `push`. Writes a full block to the file.
    pub(super) fn push(
        &mut self,
        out: &mut Output<'_>,
        push: impl FnOnce(&mut Vec<u8>),
    ) -> io::Result<()> {
        push(&mut self.waiting);
        if self.waiting.len() >= self.block_bytes { self.flush(out) } else { Ok(()) }
    }

    /// Writes pending data; returns the address of the data, or zero if there are none.
    pub(super) fn finish(&mut self, out: &mut Output<'_>) -> io::Result<u64> {
        self.flush(out)?;
        self.list(out)?;
        let Some((first, _)) = self.lists else { return Ok(0) };
        // Method deflate.
        out.block(*b"##HL", &[first], &[u8::from(self.is_equal), 0, 0, 0, 0, 0, 0, 0])
    }

    fn flush(&mut self, out: &mut Output<'_>) -> io::Result<()> {
        if self.waiting.is_empty() {
            return Ok(());
        }
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(&self.waiting)?;
        let compressed = encoder.finish()?;
        let mut data = self.kind.to_vec();
        data.extend([0; 6]);
        data.extend((self.waiting.len() as u64).to_le_bytes());
        data.extend((compressed.len() as u64).to_le_bytes());
        data.extend(compressed);
        self.blocks.push((out.block(*b"##DZ", &[], &data)?, self.written));
        self.written += self.waiting.len() as u64;
        self.waiting.clear();
        if self.blocks.len() == LIST_BLOCKS { self.list(out) } else { Ok(()) }
    }

    /// Writes a list of data blocks, and links it from the previous list.
    fn list(&mut self, out: &mut Output<'_>) -> io::Result<()> {
        let blocks = std::mem::take(&mut self.blocks);
        if blocks.is_empty() {
            return Ok(());
        }
        let links = blocks.iter().map(|(place, _)| *place);
        let links: Vec<_> = std::iter::once(0).chain(links).collect();
        let mut data = vec![if self.is_equal { EQUAL } else { 0 }, 0, 0, 0];
        data.extend((blocks.len() as u32).to_le_bytes());
        if self.is_equal {
            data.extend((self.block_bytes as u64).to_le_bytes());
        } else {
            data.extend(blocks.iter().flat_map(|(_, offset)| offset.to_le_bytes()));
        }
        let list = out.block(*b"##DL", &links, &data)?;
        let (first, last) = self.lists.map_or((list, None), |(first, last)| (first, Some(last)));
        self.lists = Some((first, list));
        match last {
            Some(last) => out.replace(last + BLOCK_HEAD_BYTES as u64, &list.to_le_bytes()),
            None => Ok(()),
        }
    }
}
