//! Writes a record file.

use super::encoding::{BorrowedKind, END_MARK, RECORD_BYTES_MAX, Recordable, encode, prefix};
use super::header::Header;
use super::{Device, Record, RecordKind};
use std::io::{self, BufWriter, Write};
use wire::time::Timestamp;

/// Bytes gathered before the file sees them.
const BUFFER_BYTES: usize = 256 * 1024;

/// Appends records to anything that takes bytes. [`finish`](Self::finish) says that the record is
/// whole; dropped without it, what was written still arrives, and a reader says that the end is
/// missing.
#[derive(Debug)]
pub struct RecordWriter<W: Write> {
    out: BufWriter<W>,
    payload: Vec<u8>,
    last: Timestamp,
    records: u64,
}

impl<W: Write> RecordWriter<W> {
    /// Writes the header.
    pub fn new(out: W, header: &Header) -> io::Result<Self> {
        let mut out = BufWriter::with_capacity(BUFFER_BYTES, out);
        header.write(&mut out)?;
        Ok(Self { out, payload: Vec::new(), last: Timestamp::ZERO, records: 0 })
    }

    /// Appends a record. One longer than [`RECORD_BYTES_MAX`] is replaced by a note that says so.
    pub fn write(&mut self, record: &Record) -> io::Result<()> {
        self.append(record.at, record.device, &record.kind)
    }

    /// Appends a [`RecordKind::Bytes`] without making one; the file comes out the same.
    pub fn write_bytes(&mut self, at: Timestamp, device: Device, bytes: &[u8]) -> io::Result<()> {
        self.append(at, device, &BorrowedKind::Bytes(bytes))
    }

    /// How many records were written.
    pub const fn records(&self) -> u64 {
        self.records
    }

    /// Marks the end and gives everything to the file.
    pub fn finish(mut self) -> io::Result<()> {
        self.end()
    }

    pub(super) fn end(&mut self) -> io::Result<()> {
        self.out.write_all(&[END_MARK])?;
        self.out.flush()
    }

    fn append<K: Recordable>(&mut self, at: Timestamp, device: Device, kind: &K) -> io::Result<()> {
        encode(&mut self.payload, self.last, at, device, kind).map_err(io::Error::other)?;
        let length = self.payload.len();
        if length > RECORD_BYTES_MAX {
            let note = RecordKind::Note(format!(
                "a record of {length} bytes was left out; {RECORD_BYTES_MAX} are allowed"
            ));
            return self.append(at, device, &note);
        }
        let (prefix, prefix_bytes) = prefix(length);
        self.out.write_all(&prefix[..prefix_bytes])?;
        self.out.write_all(&self.payload)?;
        self.last = at;
        self.records += 1;
        Ok(())
    }
}
