//! Part of a stream in a reused buffer.

use super::BUFFER_BYTES;
use super::error::LogError;

/// Bytes read and not taken yet.
#[derive(Debug)]
pub(super) struct Window {
    buffer: Vec<u8>,
    start: usize,
    end: usize,
}

impl Window {
    pub(super) fn new() -> Self {
        Self { buffer: vec![0; BUFFER_BYTES], start: 0, end: 0 }
    }

    pub(super) fn bytes(&self) -> &[u8] {
        &self.buffer[self.start..self.end]
    }

    /// Fills the buffer to `count` bytes, at most [`BUFFER_BYTES`]; returns whether it now holds them. `read` returns
    /// some bytes, and zero at the end.
    pub(super) fn has(
        &mut self,
        count: usize,
        mut read: impl FnMut(&mut [u8]) -> Result<usize, LogError>,
    ) -> Result<bool, LogError> {
        while self.end - self.start < count {
            self.buffer.copy_within(self.start..self.end, 0);
            self.end -= self.start;
            self.start = 0;
            match read(&mut self.buffer[self.end..])? {
                0 => return Ok(false),
                more => self.end += more,
            }
        }
        Ok(true)
    }

    /// Takes `count` bytes; `false` if there are fewer.
    pub(super) fn skip(
        &mut self,
        count: u64,
        mut read: impl FnMut(&mut [u8]) -> Result<usize, LogError>,
    ) -> Result<bool, LogError> {
        let mut left = count;
        loop {
            let now = left.min((self.end - self.start) as u64);
            // No more than the buffer holds.
            self.start += now as usize;
            left -= now;
            if left == 0 {
                return Ok(true);
            }
            if !self.has(1, &mut read)? {
                return Ok(false);
            }
        }
    }
}
