//! Data that go into a file while they come: compressed blocks, and lists of these.

use super::BLOCK_HEAD_BYTES;
use super::laid::push_block;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::io::{self, Seek, SeekFrom, Write};

/// Data blocks that a list has.
const LIST_BLOCKS: usize = 64;
/// A list whose blocks but the last are as long as one another.
const EQUAL: u8 = 1;

/// A file that grows.
#[derive(Debug)]
pub(super) struct Output<W> {
    out: W,
    /// Bytes written so far, always a multiple of eight.
    place: u64,
}

impl<W: Write + Seek> Output<W> {
    /// A file that begins with these bytes.
    pub(super) fn new(mut out: W, begin: &[u8]) -> io::Result<Self> {
        out.write_all(begin)?;
        Ok(Self { out, place: begin.len() as u64 })
    }

    /// Where the next byte goes.
    pub(super) const fn place(&self) -> u64 {
        self.place
    }

    /// Appends bytes, a multiple of eight of them.
    pub(super) fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.out.write_all(bytes)?;
        self.place += bytes.len() as u64;
        Ok(())
    }

    /// Appends a block; where it is.
    pub(super) fn block(&mut self, mark: [u8; 4], links: &[u64], data: &[u8]) -> io::Result<u64> {
        let mut bytes = Vec::new();
        push_block(&mut bytes, mark, links, data);
        let place = self.place;
        self.append(&bytes)?;
        Ok(place)
    }

    /// Writes over what is at `place`, and goes on at the end.
    fn replace(&mut self, place: u64, bytes: &[u8]) -> io::Result<()> {
        self.out.seek(SeekFrom::Start(place))?;
        self.out.write_all(bytes)?;
        self.out.seek(SeekFrom::Start(self.place)).map(|_| ())
    }

    /// Writes the begin anew, and gives everything to the file.
    pub(super) fn finish(mut self, begin: &[u8]) -> io::Result<()> {
        self.replace(0, begin)?;
        self.out.flush()
    }
}

/// Records, or signal data, on their way into a file.
#[derive(Debug)]
pub(super) struct Data {
    /// The kind of block that they would be in without compression.
    kind: [u8; 2],
    /// So many make a block.
    block_bytes: usize,
    /// Blocks are as long as one another, not just at least as long: what is in them is of one length.
    is_equal: bool,
    waiting: Vec<u8>,
    /// Bytes in blocks so far.
    written: u64,
    /// The blocks that are to go into the next list, and where in the data each begins.
    blocks: Vec<(u64, u64)>,
    /// Where the first list is and the last; none before the first.
    lists: Option<(u64, u64)>,
}

impl Data {
    /// Records of one length, of which `block_bytes` hold a whole number.
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

    /// Bytes so far: where the next will be.
    pub(super) const fn length(&self) -> u64 {
        self.written + self.waiting.len() as u64
    }

    /// Appends a record or a value, by what `push` appends. A block that is full goes to the file.
    pub(super) fn push<W: Write + Seek>(
        &mut self,
        out: &mut Output<W>,
        push: impl FnOnce(&mut Vec<u8>),
    ) -> io::Result<()> {
        push(&mut self.waiting);
        if self.waiting.len() >= self.block_bytes { self.flush(out) } else { Ok(()) }
    }

    /// Writes what waits; where the data are, zero where there are none.
    pub(super) fn finish<W: Write + Seek>(&mut self, out: &mut Output<W>) -> io::Result<u64> {
        self.flush(out)?;
        self.list(out)?;
        let Some((first, _)) = self.lists else { return Ok(0) };
        // Deflate.
        out.block(*b"##HL", &[first], &[u8::from(self.is_equal), 0, 0, 0, 0, 0, 0, 0])
    }

    /// Writes a data block.
    fn flush<W: Write + Seek>(&mut self, out: &mut Output<W>) -> io::Result<()> {
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

    /// Writes a list of data blocks, and its place into the list before it.
    fn list<W: Write + Seek>(&mut self, out: &mut Output<W>) -> io::Result<()> {
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
