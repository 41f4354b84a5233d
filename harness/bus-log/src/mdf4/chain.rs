//! Data of a group or of a channel, from any kind of blocks.

use super::super::BUFFER_BYTES;
use super::super::error::{Defect, LogError};
use super::BLOCK_HEAD_BYTES;
use super::blocks::{Block, Source};
use flate2::{Decompress, FlushDecompress, Status};

/// Most bytes of a transposed block, which is held in memory completely; the standard recommends 4 MB.
const TRANSPOSED_BYTES_MAX: u64 = 64 << 20;
/// Bytes of a `DZ` block before its data.
const DZ_HEAD_BYTES: u64 = 48;

/// Flag of an `LD` block: it has links to invalidation bits, after those to values.
const LD_INVALIDATION: u32 = 1 << 31;

#[derive(Debug)]
pub(super) struct Chain {
    began: u64,
    list: List,
    piece: Piece,
    /// Number of data blocks and lists so far: a file with a cycle of links has more than fit into it.
    blocks: u64,
    /// The last block of an unfinished file extends to its end.
    unfinished: bool,
    content: Content,
    lost: Option<Lost>,
}

/// Blocks whose list is lost.
#[derive(Debug)]
struct Lost {
    blocks: std::vec::IntoIter<u64>,
    /// The place behind what is known.
    end: u64,
}

/// What the blocks are read for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Content {
    /// Records with their values and invalidation bits, or signal data.
    Whole,
    /// The values; invalidation bits may be stored by themselves.
    Values,
    /// The invalidation bits that are stored by themselves.
    Invalidation,
}

#[derive(Debug, Default)]
struct List {
    /// Place of the next link to a block.
    links_at: u64,
    left: u64,
    next: u64,
}

#[derive(Debug)]
enum Piece {
    None,
    Stored { at: u64, left: u64, to_end: bool },
    Deflated(Box<Deflated>),
    Transposed { bytes: Vec<u8>, taken: usize },
}

#[derive(Debug)]
struct Deflated {
    inflate: Decompress,
    at: u64,
    left: u64,
    length: u64,
    input: Vec<u8>,
    start: usize,
    end: usize,
    /// The stream is at its end, and its checksum fits.
    has_ended: bool,
}

/// What is expected of the data of a block.
const AS_LONG: &str = "data as long as their block says";

impl Chain {
    /// The data at that address; none if it is zero.
    pub(super) fn new(address: u64, unfinished: bool) -> Self {
        Self::of(Content::Whole, address, unfinished)
    }

    pub(super) fn of(content: Content, address: u64, unfinished: bool) -> Self {
        let list = List { next: address, ..List::default() };
        Self {
            began: address,
            list,
            piece: Piece::None,
            blocks: 0,
            unfinished,
            content,
            lost: None,
        }
    }

    /// The data in these blocks, whose list lay at that address, beyond the place where the file was cut. No more is known
    /// of them from `end` on.
    pub(super) fn without_list(address: u64, blocks: Vec<u64>, end: u64) -> Self {
        let lost = Some(Lost { blocks: blocks.into_iter(), end });
        Self { lost, ..Self::new(address, false) }
    }

    pub(super) const fn began(&self) -> u64 {
        self.began
    }

    /// Reads some bytes; zero at the end.
    pub(super) fn read(
        &mut self,
        source: &mut Source<'_>,
        out: &mut [u8],
    ) -> Result<usize, LogError> {
        loop {
            let count = match &mut self.piece {
                Piece::None => 0,
                Piece::Stored { at, left, to_end } => {
                    let most = out.len().min(usize::try_from(*left).unwrap_or(usize::MAX));
                    let count = source.at(*at, &mut out[..most])?;
                    // An unfinished file is read as far as it goes.
                    if count == 0 && most > 0 && !*to_end && !self.unfinished {
                        return Err(source.cut(self.began));
                    }
                    *at += count as u64;
                    *left -= count as u64;
                    count
                }
                Piece::Deflated(deflated) => deflated.read(self.began, source, out)?,
                Piece::Transposed { bytes, taken } => {
                    let count = out.len().min(bytes.len() - *taken);
                    out[..count].copy_from_slice(&bytes[*taken..*taken + count]);
                    *taken += count;
                    count
                }
            };
            if count > 0 {
                return Ok(count);
            }
            self.piece = Piece::None;
            if !self.open(source)? {
                return Ok(0);
            }
        }
    }

    /// Advances to the next block; `false` at the end.
    fn open(&mut self, source: &mut Source<'_>) -> Result<bool, LogError> {
        let address = if let Some(lost) = &mut self.lost {
            let defect = || Defect::new("the list of the blocks", b"the end of the file").cut();
            lost.blocks.next().ok_or_else(|| source.malformed(lost.end, defect()))?
        } else if self.list.left > 0 {
            let mut link = [0; 8];
            if source.at(self.list.links_at, &mut link)? < link.len() {
                return Err(source.cut(self.list.links_at));
            }
            self.list.links_at += link.len() as u64;
            self.list.left -= 1;
            u64::from_le_bytes(link)
        } else {
            std::mem::take(&mut self.list.next)
        };
        if address == 0 {
            return Ok(self.list.left > 0 || self.list.next > 0);
        }
        self.began = address;
        self.blocks += 1;
        if self.blocks > source.length() / BLOCK_HEAD_BYTES as u64 {
            return source.bad(address, "blocks that lead to an end", b"a circle of links");
        }
        let block = source.any_block(address)?;
        match block.mark() {
            b"##DT" | b"##SD" | b"##DV" | b"##DI" => {
                let length = block.length - BLOCK_HEAD_BYTES as u64;
                let to_end = self.unfinished && length == 0;
                let left = if to_end { u64::MAX } else { length };
                self.piece = Piece::Stored { at: address + BLOCK_HEAD_BYTES as u64, left, to_end };
            }
            b"##DZ" => self.piece = compressed(&block, source)?,
            // An entry of a list cannot be a list.
            b"##HL" if self.list.left == 0 => self.list.next = block.link(0),
            b"##DL" if self.list.left == 0 => {
                self.list = List {
                    links_at: address + BLOCK_HEAD_BYTES as u64 + 8,
                    left: block.link_count.saturating_sub(1),
                    next: block.link(0),
                };
            }
            b"##LD" if self.list.left == 0 => self.list = self.columns(&block, source)?,
            other => {
                let data = "data: `##DT`, `##SD`, `##DV`, `##DI`, `##DZ`, `##DL`, `##LD` or `##HL`";
                return source.bad(address, data, other);
            }
        }
        Ok(true)
    }

    /// The links of an `LD` block to what is read.
    fn columns(&self, block: &Block, source: &Source<'_>) -> Result<List, LogError> {
        let (flags, count) = (block.u32(0), u64::from(block.u32(4)));
        let is_apart = flags & LD_INVALIDATION != 0;
        let links = 1 + count * (1 + u64::from(is_apart));
        if block.link_count < links || (is_apart && self.content == Content::Whole) {
            let found = format!("{count} blocks, {} links, flags {flags:#x}", block.link_count);
            let expected = match is_apart && self.content == Content::Whole {
                true => "records with their invalidation bits (in MDF 4.2 apart from them)",
                false => "a list with its links",
            };
            return source.bad(block.address, expected, found);
        }
        let behind = match self.content {
            Content::Whole | Content::Values => 0,
            Content::Invalidation => count,
        };
        let left = if is_apart || self.content != Content::Invalidation { count } else { 0 };
        let links_at = block.address + BLOCK_HEAD_BYTES as u64 + 8 * (1 + behind);
        Ok(List { links_at, left, next: block.link(0) })
    }
}

/// Opens the contents of a `DZ` block.
fn compressed(block: &Block, source: &mut Source<'_>) -> Result<Piece, LogError> {
    let (method, columns) = (block.u8(2), u64::from(block.u32(4)));
    let (length, left) = (block.u64(8), block.u64(16));
    if block.length.checked_sub(DZ_HEAD_BYTES).is_none_or(|room| room < left) {
        let found = format!("{left} bytes");
        return source.bad(block.address, "compressed data within their block", found);
    }
    let mut deflated = Deflated {
        inflate: Decompress::new(true),
        at: block.address + DZ_HEAD_BYTES,
        left,
        length,
        input: vec![0; BUFFER_BYTES],
        start: 0,
        end: 0,
        has_ended: false,
    };
    match method {
        0 => Ok(Piece::Deflated(Box::new(deflated))),
        1 if length <= TRANSPOSED_BYTES_MAX && columns > 0 => {
            let mut stored = Vec::new();
            let mut part = vec![0; BUFFER_BYTES];
            loop {
                match deflated.read(block.address, source, &mut part)? {
                    0 => break,
                    // `read` returns no more than the limit.
                    count => stored.extend_from_slice(&part[..count]),
                }
            }
            let columns = columns.min(length.max(1)) as usize;
            let rows = stored.len() / columns;
            let mut bytes = Vec::with_capacity(stored.len());
            for row in 0..rows {
                bytes.extend((0..columns).map(|column| stored[column * rows + row]));
            }
            bytes.extend_from_slice(&stored[rows * columns..]);
            Ok(Piece::Transposed { bytes, taken: 0 })
        }
        other => {
            let found = format!("method {other}, {length} bytes in {columns} columns");
            let expected = "deflate, transposed at most 64 MB of it";
            source.bad(block.address, expected, found)
        }
    }
}

impl Deflated {
    /// Returns the number of bytes that were put into `out`; 0 at the end. The last ones only if the checksum of all
    /// fits.
    fn read(
        &mut self,
        began: u64,
        source: &mut Source<'_>,
        out: &mut [u8],
    ) -> Result<usize, LogError> {
        let mut count = 0_usize;
        while !self.has_ended {
            if self.start == self.end && self.left > 0 {
                let most = self.input.len().min(usize::try_from(self.left).unwrap_or(usize::MAX));
                self.end = source.at(self.at, &mut self.input[..most])?;
                self.start = 0;
                if self.end == 0 {
                    return Err(source.cut(began));
                }
                self.at += self.end as u64;
                self.left -= self.end as u64;
            }
            let (taken, done) = (self.inflate.total_in(), self.inflate.total_out());
            // Behind the last byte comes the checksum; a byte more would be one too many.
            let mut behind = [0];
            let into = match usize::try_from(self.length.saturating_sub(done)) {
                Ok(0) => &mut behind[..],
                Ok(left) => {
                    let end = out.len().min(count.saturating_add(left));
                    &mut out[count..end]
                }
                Err(_) => &mut out[count..],
            };
            let given = &self.input[self.start..self.end];
            let status = self.inflate.decompress(given, into, FlushDecompress::None);
            // It takes no more than it was given, and gives no more than it had room for.
            let taken = (self.inflate.total_in() - taken) as usize;
            let given = (self.inflate.total_out() - done) as usize;
            self.start += taken;
            let is_whole = self.inflate.total_out() == self.length;
            let expected = match status {
                Err(_) => Some("compressed data that fit their checksum"),
                Ok(Status::StreamEnd) if is_whole => {
                    self.has_ended = true;
                    None
                }
                Ok(Status::Ok | Status::BufError) if taken > 0 || given > 0 => {
                    (self.inflate.total_out() > self.length).then_some(AS_LONG)
                }
                Ok(_) => Some(AS_LONG),
            };
            if let Some(expected) = expected {
                let found = format!("{} bytes of {}", self.inflate.total_out(), self.length);
                return source.bad(began, expected, found);
            }
            count += given;
            if count > 0 && !is_whole {
                break;
            }
        }
        Ok(count)
    }
}
