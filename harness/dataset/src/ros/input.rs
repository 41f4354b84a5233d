//! Bytes of a bag or of a chunk, of which every length is checked.

use std::io::{self, Read, Seek, SeekFrom};

/// The most bytes of a record, or of a chunk before and after compression.
pub(super) const BLOCK_BYTES_MAX: u64 = 256 * 1024 * 1024;

/// Why a record cannot be read.
#[derive(Debug)]
pub(super) enum Fault {
    /// The bytes end before the record does.
    Cut,
    Unreadable(io::Error),
    /// What is found, and what is expected.
    Bad(String),
}

/// Input up to an end.
#[derive(Debug)]
pub(super) struct Input<R> {
    reader: R,
    at: u64,
    end: u64,
}

impl<R: Read + Seek> Input<R> {
    pub(super) fn new(mut reader: R) -> io::Result<Self> {
        let end = reader.seek(SeekFrom::End(0))?;
        reader.rewind()?;
        Ok(Self { reader, at: 0, end })
    }

    pub(super) const fn at(&self) -> u64 {
        self.at
    }

    pub(super) const fn end(&self) -> u64 {
        self.end
    }

    pub(super) fn seek(&mut self, at: u64) -> Result<(), Fault> {
        if at > self.end {
            return Err(Fault::Cut);
        }
        // Within what is buffered, this costs nothing.
        let by = at.cast_signed().wrapping_sub(self.at.cast_signed());
        self.reader.seek_relative(by).map_err(Fault::Unreadable)?;
        self.at = at;
        Ok(())
    }

    /// Reads `length` bytes. The memory grows with what is there, not with what a damaged length says.
    pub(super) fn block(&mut self, length: u64) -> Result<Vec<u8>, Fault> {
        if length > self.end - self.at {
            return Err(Fault::Cut);
        }
        if length > BLOCK_BYTES_MAX {
            let most = BLOCK_BYTES_MAX;
            return Err(Fault::Bad(format!("found {length} bytes, expected at most {most}")));
        }
        let mut block = Vec::new();
        let read = (&mut self.reader).take(length).read_to_end(&mut block);
        self.at += read.map_err(Fault::Unreadable)? as u64;
        if (block.len() as u64) < length { Err(Fault::Cut) } else { Ok(block) }
    }

    pub(super) fn bytes<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        if N as u64 > self.end - self.at {
            return Err(Fault::Cut);
        }
        let mut bytes = [0; N];
        self.reader.read_exact(&mut bytes).map_err(Fault::Unreadable)?;
        self.at += N as u64;
        Ok(bytes)
    }

    pub(super) fn u16(&mut self) -> Result<u16, Fault> {
        self.bytes().map(u16::from_le_bytes)
    }

    pub(super) fn u32(&mut self) -> Result<u32, Fault> {
        self.bytes().map(u32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> Result<u64, Fault> {
        self.bytes().map(u64::from_le_bytes)
    }

    /// A text after its length.
    pub(super) fn text(&mut self) -> Result<String, Fault> {
        let length = self.u32()?;
        Ok(String::from_utf8_lossy(&self.block(length.into())?).into_owned())
    }
}
