//! Writes an MDF file of version 4.10.

use super::super::entry::{Direction, Entry, Payload};
use super::super::error::LogError;
use super::super::numbers::{CHANNELS_MAX, Numbers};
use super::super::{Format, Kept};
use super::head::{self, Written};
use super::{BLOCK_HEAD_BYTES, Kind};
use embedded_can::Frame as _;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use wire::can::{CanFrame, Id};

/// Records of a data block: 344 KB of data frames.
const BLOCK_RECORDS: usize = 4_096;
/// Data blocks that a list has.
const LIST_BLOCKS: usize = 64;

/// Writes an MDF file of version 4.10.
///
/// The measurement begins with the first entry. `canN` is the bus N + 1 where that is free, any other name the lowest
/// that is free; beyond 32 channels entries are left out. An entry whose direction is not known counts as received: the
/// format has no word for it. Frames, remote requests and error frames are groups of their own, each with a buffer of
/// 4,096 records.
#[derive(Debug)]
pub struct Writer<W: Write + Seek> {
    path: PathBuf,
    out: W,
    /// Bytes written so far, always a multiple of eight.
    place: u64,
    numbers: Numbers,
    /// Nanoseconds since 1970; none before the first entry.
    began: Option<i64>,
    groups: [Group; Kind::ALL.len()],
}

/// The records of a kind.
#[derive(Debug, Default)]
struct Group {
    /// Those that are to go into the next data block.
    waiting: Vec<u8>,
    count: u64,
    /// The data blocks that are to go into the next list.
    blocks: Vec<u64>,
    /// Where the first list is and the last; none before the first.
    lists: Option<(u64, u64)>,
}

impl<W: Write + Seek> Writer<W> {
    /// Makes room for the head of the file in `out`; `path` is named in errors.
    ///
    /// # Errors
    /// When that cannot be written.
    pub fn new(path: &Path, mut out: W) -> Result<Self, LogError> {
        let head = head::head(false, 0, Default::default());
        out.write_all(&head).map_err(|source| LogError::unwritable(path, source))?;
        let numbers = Numbers::up_to(CHANNELS_MAX);
        let (path, place) = (path.to_owned(), head.len() as u64);
        Ok(Self { path, out, place, numbers, began: None, groups: Default::default() })
    }

    /// Appends an entry. Bytes of serial lines are left out, and of an error frame everything but that it
    /// was.
    ///
    /// # Errors
    /// When the file cannot be written; when the entry is from before 1970.
    pub fn write(&mut self, entry: &Entry) -> Result<Kept, LogError> {
        let at = entry.at.as_nanos();
        if at < 0 {
            return Err(LogError::before_1970(&self.path, Format::Mdf4));
        }
        let (kind, frame) = match &entry.payload {
            Payload::Frame(frame) if frame.is_remote() => (Kind::Remote, Some(frame)),
            Payload::Frame(frame) => (Kind::Data, Some(frame)),
            Payload::Error(_) => (Kind::Error, None),
            Payload::Serial(_) => return Ok(Kept::LeftOut),
        };
        let number = self.numbers.of(entry.channel).and_then(|number| u8::try_from(number).ok());
        let Some(number) = number else { return Ok(Kept::LeftOut) };
        // Both are since 1970.
        let since = at - *self.began.get_or_insert(at);
        let group = &mut self.groups[kind as usize];
        let end = group.waiting.len() + head::record_bytes(kind);
        group.waiting.extend(since.to_le_bytes());
        group.waiting.push(number);
        if let Some(frame) = frame {
            push_frame(&mut group.waiting, frame, entry.direction);
        }
        // A frame has less than 64 bytes, a remote request no flags.
        group.waiting.resize(end, 0);
        group.count += 1;
        if group.waiting.len() == BLOCK_RECORDS * head::record_bytes(kind) {
            self.flush(kind).map_err(|source| LogError::unwritable(&self.path, source))?;
        }
        Ok(Kept::Written)
    }

    /// Writes what waits and the head, and gives everything to the file.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn finish(mut self) -> Result<(), LogError> {
        self.end().map_err(|source| LogError::unwritable(&self.path, source))
    }

    fn end(&mut self) -> io::Result<()> {
        let mut written = [Written::default(); Kind::ALL.len()];
        for kind in Kind::ALL {
            self.flush(kind)?;
            self.list(kind)?;
            let group = &self.groups[kind as usize];
            let (records, mut data) = (group.count, 0);
            if let Some((first, _)) = group.lists {
                // All blocks but the last are as long as one another; deflate.
                data = self.block(*b"##HL", &[first], &[1, 0, 0, 0, 0, 0, 0, 0])?;
            }
            written[kind as usize] = Written { records, data };
        }
        let began = self.began.unwrap_or(0).unsigned_abs();
        let head = head::head(true, began, written);
        self.out.seek(SeekFrom::Start(0))?;
        self.out.write_all(&head)?;
        self.out.flush()
    }

    /// Writes a data block.
    fn flush(&mut self, kind: Kind) -> io::Result<()> {
        let records = std::mem::take(&mut self.groups[kind as usize].waiting);
        if records.is_empty() {
            return Ok(());
        }
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(&records)?;
        let compressed = encoder.finish()?;
        let mut data = b"DT\0\0\0\0\0\0".to_vec();
        data.extend((records.len() as u64).to_le_bytes());
        data.extend((compressed.len() as u64).to_le_bytes());
        data.extend(compressed);
        let block = self.block(*b"##DZ", &[], &data)?;
        let group = &mut self.groups[kind as usize];
        group.waiting = records;
        group.waiting.clear();
        group.blocks.push(block);
        if group.blocks.len() == LIST_BLOCKS { self.list(kind) } else { Ok(()) }
    }

    /// Writes a list of data blocks, and its place into the list before it.
    fn list(&mut self, kind: Kind) -> io::Result<()> {
        let blocks = std::mem::take(&mut self.groups[kind as usize].blocks);
        if blocks.is_empty() {
            return Ok(());
        }
        let links: Vec<_> = std::iter::once(0).chain(blocks.iter().copied()).collect();
        let mut data = vec![1, 0, 0, 0];
        data.extend((blocks.len() as u32).to_le_bytes());
        data.extend(((BLOCK_RECORDS * head::record_bytes(kind)) as u64).to_le_bytes());
        let list = self.block(*b"##DL", &links, &data)?;
        let group = &mut self.groups[kind as usize];
        let (first, last) = group.lists.map_or((list, None), |(first, last)| (first, Some(last)));
        group.lists = Some((first, list));
        if let Some(last) = last {
            self.out.seek(SeekFrom::Start(last + BLOCK_HEAD_BYTES as u64))?;
            self.out.write_all(&list.to_le_bytes())?;
            self.out.seek(SeekFrom::Start(self.place))?;
        }
        Ok(())
    }

    /// Writes a block; where it is.
    fn block(&mut self, mark: [u8; 4], links: &[u64], data: &[u8]) -> io::Result<u64> {
        let mut bytes = Vec::new();
        head::push_block(&mut bytes, mark, links, data);
        self.out.write_all(&bytes)?;
        let place = self.place;
        self.place += bytes.len() as u64;
        Ok(place)
    }
}

/// A frame from behind its channel.
fn push_frame(record: &mut Vec<u8>, frame: &CanFrame, direction: Option<Direction>) {
    let (id, is_extended) = match frame.id() {
        Id::Standard(id) => (u32::from(id.as_raw()), false),
        Id::Extended(id) => (id.as_raw(), true),
    };
    let sent = direction == Some(Direction::Tx);
    record.extend(id.to_le_bytes());
    let length = frame.data().len() as u8;
    record.extend([u8::from(is_extended), frame.dlc() as u8, length, u8::from(sent)]);
    if !frame.is_remote() {
        let flags = frame.fd_flags();
        let is = |flag: Option<bool>| u8::from(flag == Some(true));
        record.push(u8::from(flags.is_some()));
        record.push(is(flags.map(|flags| flags.bit_rate_switch)));
        record.push(is(flags.map(|flags| flags.error_state)));
        record.extend_from_slice(frame.data());
    }
}
