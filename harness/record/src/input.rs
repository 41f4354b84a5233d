//! The bytes of a file, counted, so that errors can name offsets in it.

use std::fmt;
use std::io::{self, BufRead as _, BufReader, Read};

const BUFFER_BYTES: usize = 256 * 1024;

/// A file that is read from its beginning.
pub(super) struct Input {
    file: BufReader<Box<dyn Read + Send>>,
    /// Number of bytes read so far.
    offset: u64,
}

impl fmt::Debug for Input {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Input").field("offset", &self.offset).finish_non_exhaustive()
    }
}

impl Input {
    pub(super) fn new(file: Box<dyn Read + Send>) -> Self {
        Self { file: BufReader::with_capacity(BUFFER_BYTES, file), offset: 0 }
    }

    /// Offset of the next byte in the file.
    pub(super) const fn offset(&self) -> u64 {
        self.offset
    }

    /// Appends the next `count` bytes, or as many as there are; returns how many.
    pub(super) fn append_to(&mut self, block: &mut Vec<u8>, count: usize) -> io::Result<usize> {
        // Nearly always they are in the buffer.
        if let Some(at_hand) = self.file.buffer().get(..count) {
            block.extend_from_slice(at_hand);
            self.file.consume(count);
            self.offset += count as u64;
            return Ok(count);
        }
        let begin = block.len();
        self.by_ref().take(count as u64).read_to_end(block)?;
        Ok(block.len() - begin)
    }
}

impl Read for Input {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let bytes = self.file.read(buffer)?;
        self.offset += bytes as u64;
        Ok(bytes)
    }
}
