//! Lines of a file in a reused buffer, each of limited length.

use super::error::{Defect, LogError, Place};
use super::{BUFFER_BYTES, Format};
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

/// Longest line: 64 bytes of a CAN FD frame with everything that Vector's tools append take less than 500; the rest is
/// for comments.
pub const LINE_BYTES_MAX: usize = 4096;

#[derive(Debug)]
pub(super) struct Lines<R: Read> {
    input: BufReader<R>,
    line: Vec<u8>,
    number: u64,
    /// Whether the last line is one of an event, without an end of line.
    is_open: bool,
    path: PathBuf,
    format: Format,
}

impl<R: Read> Lines<R> {
    pub(super) fn new(path: &Path, input: R, format: Format) -> Self {
        let input = BufReader::with_capacity(BUFFER_BYTES, input);
        Self { input, line: Vec::new(), number: 0, is_open: false, path: path.to_owned(), format }
    }

    /// Advances to the next line; `false` at the end of the file.
    pub(super) fn advance(&mut self) -> Result<bool, LogError> {
        self.line.clear();
        self.number += 1;
        let mut bounded = (&mut self.input).take(LINE_BYTES_MAX as u64 + 1);
        bounded
            .read_until(b'\n', &mut self.line)
            .map_err(|source| LogError::unreadable(&self.path, source))?;
        if self.line.len() > LINE_BYTES_MAX {
            return Err(self.malformed(Defect::new("a line of at most 4096 bytes", &self.line)));
        }
        if self.line.is_empty() {
            return Ok(false);
        }
        let begins = |first: &u8| first.is_ascii_digit() || *first == b'(';
        let is_event = self.text().first().is_some_and(begins);
        self.is_open = is_event && !self.line.ends_with(b"\n");
        Ok(true)
    }

    pub(super) const fn number(&self) -> u64 {
        self.number
    }

    /// Says so if the last line is cut, as far as can be seen: half of a frame may look like a whole one.
    pub(super) fn note(&self) -> Option<String> {
        let what = "its last line has no end: if the file is cut short, that line is wrong";
        self.is_open.then(|| what.to_owned())
    }

    /// The line, without surrounding white space.
    pub(super) fn text(&self) -> &[u8] {
        self.line.trim_ascii()
    }

    pub(super) fn malformed(&self, defect: Defect) -> LogError {
        let defect = if self.is_open { defect.cut() } else { defect };
        LogError::malformed(&self.path, self.format, Place::Line(self.number), defect)
    }
}
