//! Writes a record file.

use super::blocks::{BLOCK_BYTES, Check, END, NEXT, TRAILER};
use super::encoding::{BorrowedKind, MARK, RECORD_BYTES_MAX, encode, prefix};
use super::header::Header;
use super::{Device, Record, RecordKind};
use serde::Serialize;
use std::io::{self, Write};
use wire::time::Timestamp;

/// Appends records to a byte stream. [`finish`](Self::finish) marks the record as complete. If dropped without it,
/// everything is still written out, but a reader reports the missing end.
///
/// What it writes to is hidden: it is asked once a block, and what is done for each record is compiled once.
pub struct RecordWriter<'a> {
    out: Box<dyn Write + Send + 'a>,
    /// The current block; `given` of its bytes are in `out`.
    block: Vec<u8>,
    given: usize,
    check: Check,
    payload: Vec<u8>,
    last: Timestamp,
    records: u64,
}

impl<'a> RecordWriter<'a> {
    /// Writes the header at once, so that the file can be recognised as a record from now on.
    pub fn new(out: impl Write + Send + 'a, header: &Header) -> io::Result<Self> {
        let mut out: Box<dyn Write + Send + 'a> = Box::new(out);
        out.write_all(&header.bytes()?)?;
        out.flush()?;
        let block = Vec::with_capacity(2 * BLOCK_BYTES);
        let (payload, last) = (Vec::new(), Timestamp::ZERO);
        let check = Check::default();
        Ok(Self { out, block, given: 0, check, payload, last, records: 0 })
    }

    /// Appends a record. One longer than [`RECORD_BYTES_MAX`] is replaced by a note.
    pub fn write(&mut self, record: &Record) -> io::Result<()> {
        self.append(record.at, record.device, &record.kind)
    }

    /// Appends a [`RecordKind::Bytes`] without building one; the file is the same.
    pub fn write_bytes(&mut self, at: Timestamp, device: Device, bytes: &[u8]) -> io::Result<()> {
        self.append(at, device, &BorrowedKind::Bytes(bytes))
    }

    /// Number of records written.
    pub const fn records(&self) -> u64 {
        self.records
    }

    /// Writes everything to the file. This does not change the file's content.
    pub fn flush(&mut self) -> io::Result<()> {
        let new = &self.block[self.given..];
        // Set before the attempt: bytes that a full disk took in part must not be written twice.
        self.given = self.block.len();
        self.out.write_all(new)?;
        self.out.flush()
    }

    /// Marks the end and writes everything to the file.
    pub fn finish(mut self) -> io::Result<()> {
        self.end()
    }

    pub(super) fn end(&mut self) -> io::Result<()> {
        self.close(END);
        self.block.extend_from_slice(&TRAILER);
        self.flush()
    }

    fn append(&mut self, at: Timestamp, device: Device, kind: &impl Serialize) -> io::Result<()> {
        encode(&mut self.payload, self.last, at, device, kind).map_err(io::Error::other)?;
        let length = self.payload.len();
        if length > RECORD_BYTES_MAX {
            let note = RecordKind::Note(format!(
                "a record of {length} bytes was left out; {RECORD_BYTES_MAX} are allowed"
            ));
            return self.append(at, device, &note);
        }
        let (prefix, prefix_bytes) = prefix(length);
        self.block.extend_from_slice(&prefix[..prefix_bytes]);
        self.block.extend_from_slice(&self.payload);
        self.last = at;
        self.records += 1;
        if self.block.len() < BLOCK_BYTES {
            return Ok(());
        }
        self.close(NEXT);
        let flushed = self.flush();
        self.block.clear();
        self.given = 0;
        flushed
    }

    fn close(&mut self, mark: u8) {
        self.block.extend_from_slice(&[MARK, mark]);
        self.check = self.check.of(&self.block);
        self.block.extend_from_slice(&self.check.bytes());
    }
}

impl Drop for RecordWriter<'_> {
    fn drop(&mut self) {
        // Best effort: a caller that needs the error calls `finish`.
        let _ = self.flush();
    }
}
