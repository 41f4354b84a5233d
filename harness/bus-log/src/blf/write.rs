//! Writes a BLF file.

use super::super::entry::{Channel, Direction, Entry, Payload};
use super::super::numbers::{CHANNELS_MAX, Numbers};
use super::super::{Kept, WriteEntries};
use super::{
    APP_TEXT, BEGAN_AT, BRS, CAN_ERROR_EXT, CAN_FD_MESSAGE, CAN_MESSAGE, CONTAINER_HEAD_BYTES, EDL,
    ESI, EXTENDED, FILE_HEAD_BYTES, FILE_MARK, LOG_CONTAINER, NANOS, OBJECT_BASE_BYTES,
    OBJECT_HEAD_BYTES, OBJECT_MARK, REMOTE, SENT, ZLIB, date,
};
use embedded_can::Frame as _;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::fmt;
use std::io::{self, Seek, SeekFrom, Write};
use wire::can::{CanFrame, DATA_BYTES_MAX, FD_BYTES_MAX, Id};

/// Bytes in a container, as in Vector's tools.
const CONTAINER_BYTES: usize = 128 * 1024;

const NANOS_A_MILLISECOND: i64 = 1_000_000;

/// Writes a BLF file.
///
/// The measurement begins with the first entry, to the millisecond; earlier entries are put at its start. `canN` gets
/// channel N + 1 if that is free, any other name the lowest free one; a comment before its first entry has the name.
/// Entries beyond 32 channels are left out. An entry with unknown direction counts as received, because the format cannot
/// express it.
#[derive(Debug)]
pub(crate) struct Writer<W: Write + Seek> {
    out: W,
    numbers: Numbers,
    /// Start and end of the measurement, ns since 1970; `None` before the first entry.
    times: Option<(i64, i64)>,
    objects: u32,
    /// Bytes of the file, with and without compression.
    bytes: (u64, u64),
    /// Bytes for the next container.
    waiting: Vec<u8>,
}

impl<W: Write + Seek> Writer<W> {
    /// Reserves room for the head of the file in `out`.
    pub(crate) fn new(out: W) -> io::Result<Self> {
        let bytes = (FILE_HEAD_BYTES as u64, FILE_HEAD_BYTES as u64);
        let numbers = Numbers::up_to(CHANNELS_MAX);
        let waiting = Vec::with_capacity(CONTAINER_BYTES + 256);
        let mut writer = Self { out, numbers, times: None, objects: 0, bytes, waiting };
        let head = writer.head();
        writer.out.write_all(&head)?;
        Ok(writer)
    }
}

impl<W: Write + Seek + fmt::Debug> WriteEntries for Writer<W> {
    /// Bytes of serial lines are left out, and so are the details of an error frame.
    fn write(&mut self, entry: &Entry) -> io::Result<Kept> {
        let at = entry.at.as_nanos();
        let (kind, length) = match &entry.payload {
            Payload::Frame(frame) if frame.fd_flags().is_some() => {
                (CAN_FD_MESSAGE, 20 + FD_BYTES_MAX)
            }
            Payload::Frame(_) => (CAN_MESSAGE, 8 + DATA_BYTES_MAX),
            Payload::Error(_) => (CAN_ERROR_EXT, 32),
            Payload::Serial(_) => return Ok(Kept::LeftOut),
        };
        let Some((number, is_new)) = self.numbers.of(entry.channel) else {
            return Ok(Kept::LeftOut);
        };
        let (began, ended) = self.times.unwrap_or((at - at % NANOS_A_MILLISECOND, at));
        self.times = Some((began, ended.max(at)));
        let since = (at - began).max(0) as u64;
        if is_new {
            let mut text = format!("channel {number} is {}", entry.channel);
            // Every object ends at a multiple of four bytes: readers differ in what they expect behind others.
            while !text.len().is_multiple_of(4) {
                text.push(' ');
            }
            self.object(APP_TEXT, since, 16 + text.len(), |waiting| {
                // The comment of a measurement; a reserved word; its length; a reserved word.
                waiting.extend([0, 0, text.len() as u32, 0].map(u32::to_le_bytes).concat());
                waiting.extend(text.as_bytes());
            });
        }
        self.object(kind, since, length, |waiting| {
            // At most 32.
            waiting.extend((number as u16).to_le_bytes());
            if let Payload::Frame(frame) = &entry.payload {
                push_frame(waiting, frame, entry.direction);
            }
        });
        if self.waiting.len() >= CONTAINER_BYTES {
            self.flush()?;
        }
        Ok(Kept::Written)
    }

    fn numbered(&self) -> Vec<(usize, Channel)> {
        self.numbers.named()
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        if !self.waiting.is_empty() {
            self.flush()?;
        }
        let head = self.head();
        self.out.seek(SeekFrom::Start(0))?;
        self.out.write_all(&head)?;
        self.out.flush()
    }
}

impl<W: Write + Seek> Writer<W> {
    /// Appends an object of that type and length, without its head; values that `push` leaves are unknown, and zero.
    fn object(&mut self, kind: u32, since: u64, length: usize, push: impl FnOnce(&mut Vec<u8>)) {
        let waiting = &mut self.waiting;
        let end = waiting.len() + OBJECT_HEAD_BYTES + length;
        push_base(waiting, OBJECT_HEAD_BYTES, OBJECT_HEAD_BYTES + length, kind);
        waiting.extend(NANOS.to_le_bytes());
        waiting.extend([0; 4]);
        waiting.extend(since.to_le_bytes());
        push(waiting);
        waiting.resize(end, 0);
        self.objects = self.objects.saturating_add(1);
    }

    /// Writes a container. Bytes beyond its length wait for the next.
    fn flush(&mut self) -> io::Result<()> {
        let count = self.waiting.len().min(CONTAINER_BYTES);
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(&self.waiting[..count])?;
        let data = encoder.finish()?;
        self.waiting.drain(..count);
        let length = OBJECT_BASE_BYTES + CONTAINER_HEAD_BYTES + data.len();
        let mut head = Vec::new();
        push_base(&mut head, OBJECT_BASE_BYTES, length, LOG_CONTAINER);
        head.extend(ZLIB.to_le_bytes());
        head.extend([0; 6]);
        head.extend((count as u32).to_le_bytes());
        head.extend([0; 4]);
        let padding = length % 4;
        self.out.write_all(&head)?;
        self.out.write_all(&data)?;
        self.out.write_all(&[0; 4][..padding])?;
        self.bytes.0 += (length + padding) as u64;
        self.bytes.1 += (head.len() + count) as u64;
        Ok(())
    }

    fn head(&self) -> [u8; FILE_HEAD_BYTES] {
        let mut head = [0; FILE_HEAD_BYTES];
        let mut put = |place: usize, bytes: &[u8]| {
            head[place..place + bytes.len()].copy_from_slice(bytes);
        };
        put(0, FILE_MARK);
        put(4, &(FILE_HEAD_BYTES as u32).to_le_bytes());
        // The program is not one of Vector's; the format version is that of python-can.
        put(12, &[2, 6, 8, 1]);
        put(16, &self.bytes.0.to_le_bytes());
        put(24, &self.bytes.1.to_le_bytes());
        put(32, &self.objects.to_le_bytes());
        if let Some((began, ended)) = self.times {
            put(BEGAN_AT, &date::format(began));
            put(BEGAN_AT + date::BYTES, &date::format(ended));
        }
        head
    }
}

/// Appends the common start of an object.
fn push_base(bytes: &mut Vec<u8>, head: usize, length: usize, kind: u32) {
    bytes.extend(OBJECT_MARK);
    // No object here is longer than a container.
    bytes.extend((head as u16).to_le_bytes());
    bytes.extend(1u16.to_le_bytes());
    bytes.extend((length as u32).to_le_bytes());
    bytes.extend(kind.to_le_bytes());
}

/// A frame, from after its channel on.
fn push_frame(bytes: &mut Vec<u8>, frame: &CanFrame, direction: Option<Direction>) {
    let sent = if direction == Some(Direction::Tx) { SENT } else { 0 };
    let remote = if frame.is_remote() { REMOTE } else { 0 };
    let id = match frame.id() {
        Id::Standard(id) => u32::from(id.as_raw()),
        Id::Extended(id) => id.as_raw() | EXTENDED,
    };
    bytes.extend([sent | remote, frame.dlc() as u8]);
    bytes.extend(id.to_le_bytes());
    if let Some(flags) = frame.fd_flags() {
        let brs = if flags.bit_rate_switch { BRS } else { 0 };
        let esi = if flags.error_state { ESI } else { 0 };
        // Duration and bits on the wire are unknown.
        bytes.extend([0; 5]);
        bytes.extend([EDL | brs | esi, frame.length() as u8]);
        bytes.extend([0; 5]);
    }
    bytes.extend_from_slice(frame.data());
}
