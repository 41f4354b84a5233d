//! Reads blocks of an MDF file by address.

use super::super::Format;
use super::super::error::{Defect, LogError, Place};
use super::{BLOCK_HEAD_BYTES, FILE_MARK, IDENTIFICATION_BYTES, UNFINISHED_MARK};
use std::fmt;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

const LINKS_MAX: usize = 8;
/// Most bytes of a block after its links that are kept.
const DATA_MAX: usize = 256;

/// Most bytes of a block that is read completely: a table of values, a text.
const WHOLE_BYTES_MAX: u64 = 4 << 20;

/// Unfinished parts that do not matter here: counts of records, the length of the last data block, and the bytes of a
/// variable-length group.
const UNFINISHED: u16 = 0x2f;

/// Bytes with random access.
pub trait Input: Read + Seek + fmt::Debug {}

impl<T: Read + Seek + fmt::Debug> Input for T {}

/// A file with random access.
#[derive(Debug)]
pub(super) struct Source<'s> {
    path: PathBuf,
    input: Box<dyn Input + 's>,
    length: u64,
}

pub(super) struct Block {
    pub(super) address: u64,
    pub(super) length: u64,
    pub(super) link_count: u64,
    mark: [u8; 4],
    links: [u64; LINKS_MAX],
    data: [u8; DATA_MAX],
    known: usize,
}

impl<'s> Source<'s> {
    /// Opens a file; returns its header, too, and whether its writer did not finish it.
    pub(super) fn open(
        path: &Path,
        mut input: impl Input + 's,
    ) -> Result<(Self, Block, bool), LogError> {
        let length = input.seek(SeekFrom::End(0));
        let length = length.map_err(|source| LogError::unreadable(path, source))?;
        let mut source = Self { path: path.to_owned(), input: Box::new(input), length };
        let mut head = [0; IDENTIFICATION_BYTES];
        source.at(0, &mut head)?;
        let is_finished = head.starts_with(FILE_MARK);
        let version = u16::from_le_bytes([head[28], head[29]]);
        let unfinished = u16::from_le_bytes([head[60], head[61]]);
        if !is_finished && !head.starts_with(UNFINISHED_MARK) {
            let found = String::from_utf8_lossy(&head[..8]);
            return source.bad(0, "`MDF` and its version", found.as_bytes());
        }
        if !(400..500).contains(&version) {
            return source.bad(0, "version 4 of MDF", format!("version {version}"));
        }
        if !is_finished && unfinished & !UNFINISHED != 0 {
            let found = format!("flags {unfinished:#06x}");
            return source.bad(0, "a file that its logger finished", found);
        }
        let header = source.block(IDENTIFICATION_BYTES as u64, "##HD")?;
        Ok((source, header, !is_finished))
    }

    pub(super) const fn length(&self) -> u64 {
        self.length
    }

    pub(super) fn malformed(&self, address: u64, defect: Defect) -> LogError {
        LogError::malformed(&self.path, Format::Mdf4, Place::Byte(address), defect)
    }

    /// The error that something else than expected is found in the block at that address.
    pub(super) fn bad<T>(
        &self,
        address: u64,
        expected: &'static str,
        found: impl AsRef<[u8]>,
    ) -> Result<T, LogError> {
        Err(self.malformed(address, Defect::new(expected, found)))
    }

    /// Fills `out`, or less at the end of the file.
    pub(super) fn at(&mut self, place: u64, out: &mut [u8]) -> Result<usize, LogError> {
        if place >= self.length {
            return Ok(0);
        }
        let mut read = || -> io::Result<usize> {
            self.input.seek(SeekFrom::Start(place))?;
            let mut input = (&mut self.input).take(out.len() as u64);
            Ok(io::copy(&mut input, &mut &mut *out)? as usize)
        };
        read().map_err(|source| LogError::unreadable(&self.path, source))
    }

    pub(super) fn any_block(&mut self, address: u64) -> Result<Block, LogError> {
        let mut head = [0; BLOCK_HEAD_BYTES];
        if self.at(address, &mut head)? < head.len() {
            let defect = Defect::new("a block", b"the end of the file");
            return Err(self.malformed(address, defect.cut()));
        }
        let word = |place: usize| {
            head[place..].first_chunk().map_or(0, |bytes| u64::from_le_bytes(*bytes))
        };
        let (length, link_count) = (word(8), word(16));
        let links_bytes = link_count.checked_mul(8).and_then(|l| l.checked_add(head.len() as u64));
        let Some(data_bytes) = links_bytes.and_then(|bytes| length.checked_sub(bytes)) else {
            let found = format!("{length} bytes, {link_count} links");
            return self.bad(address, "a block that has room for its links", found);
        };
        let mut links = [0; LINKS_MAX];
        let mut bytes = [0; 8 * LINKS_MAX];
        let count = link_count.min(LINKS_MAX as u64) as usize;
        let behind = address + head.len() as u64;
        if self.at(behind, &mut bytes[..8 * count])? < 8 * count {
            return Err(self.cut(address));
        }
        for (link, bytes) in links.iter_mut().zip(bytes.as_chunks().0) {
            *link = u64::from_le_bytes(*bytes);
        }
        let mut data = [0; DATA_MAX];
        let most = data_bytes.min(DATA_MAX as u64) as usize;
        let known = self.at(behind.saturating_add(8 * link_count), &mut data[..most])?;
        let mark = *head.first_chunk().unwrap_or(&[0; 4]);
        Ok(Block { address, length, link_count, mark, links, data, known })
    }

    /// Reads the block at that address, which must have that mark.
    pub(super) fn block(&mut self, address: u64, mark: &'static str) -> Result<Block, LogError> {
        let block = self.any_block(address)?;
        if block.mark == mark.as_bytes() {
            return Ok(block);
        }
        self.bad(address, mark, block.mark)
    }

    /// Reads all links of a block, and the bytes after them.
    pub(super) fn whole(&mut self, block: &Block) -> Result<(Vec<u64>, Vec<u8>), LogError> {
        let length = block.length - BLOCK_HEAD_BYTES as u64;
        if length > WHOLE_BYTES_MAX {
            return self.bad(block.address, "a block of at most 4 MB", format!("{length} bytes"));
        }
        let mut bytes = vec![0; length as usize];
        if self.at(block.address + BLOCK_HEAD_BYTES as u64, &mut bytes)? < bytes.len() {
            return Err(self.cut(block.address));
        }
        // The block has room for its links.
        let data = bytes.split_off(8 * block.link_count as usize);
        let links = bytes.as_chunks().0.iter().map(|link| u64::from_le_bytes(*link));
        Ok((links.collect(), data))
    }

    /// Reads the text at that address, plain or in XML, of any length; empty for address zero.
    pub(super) fn text(&mut self, address: u64) -> Result<String, LogError> {
        if address == 0 {
            return Ok(String::new());
        }
        let block = self.any_block(address)?;
        if !matches!(block.mark(), b"##TX" | b"##MD") {
            return self.bad(address, "a text: `##TX` or `##MD`", block.mark());
        }
        let (_, data) = self.whole(&block)?;
        let text = data.split(|byte| *byte == 0).next().unwrap_or_default();
        let text = String::from_utf8_lossy(text).into_owned();
        if block.mark() == b"##TX" {
            return Ok(text);
        }
        let within = text.split_once("<TX>").and_then(|(_, rest)| rest.split_once("</TX>"));
        let within = within.map_or("", |(within, _)| within);
        Ok(within.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&"))
    }

    pub(super) fn cut(&self, address: u64) -> LogError {
        self.malformed(address, Defect::new("a whole block", b"the end of the file").cut())
    }
}

impl Block {
    pub(super) const fn mark(&self) -> &[u8; 4] {
        &self.mark
    }

    /// Bytes of records in this block: in `DT`, or in a compressed block that has been one, as it says first.
    pub(super) fn record_bytes(&self) -> Option<u64> {
        match &self.mark {
            b"##DT" => Some(self.length - BLOCK_HEAD_BYTES as u64),
            b"##DZ" if self.bytes(0) == *b"DT" => Some(self.u64(8)),
            _ => None,
        }
    }

    /// The link of that number from 0; zero if the block has fewer.
    pub(super) fn link(&self, number: usize) -> u64 {
        self.links.get(number).copied().unwrap_or(0)
    }

    /// Bytes after its links; zero where the block is too short, as one of an earlier version.
    pub(super) fn bytes<const N: usize>(&self, place: usize) -> [u8; N] {
        let mut bytes = [0; N];
        let given = self.data[..self.known].get(place..).unwrap_or_default();
        let count = given.len().min(N);
        bytes[..count].copy_from_slice(&given[..count]);
        bytes
    }

    pub(super) fn u8(&self, place: usize) -> u8 {
        let [byte] = self.bytes(place);
        byte
    }

    pub(super) fn u16(&self, place: usize) -> u16 {
        u16::from_le_bytes(self.bytes(place))
    }

    pub(super) fn u32(&self, place: usize) -> u32 {
        u32::from_le_bytes(self.bytes(place))
    }

    pub(super) fn u64(&self, place: usize) -> u64 {
        u64::from_le_bytes(self.bytes(place))
    }

    pub(super) fn f64(&self, place: usize) -> f64 {
        f64::from_le_bytes(self.bytes(place))
    }
}
