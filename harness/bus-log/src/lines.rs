//! Lines of a file in a reused buffer, each of limited length.

use super::error::{Defect, LogError, Place};
use super::{BUFFER_BYTES, Format};
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

/// Longest line: 64 bytes of a CAN FD frame with everything that Vector's tools append take less than 500; the rest is
/// for comments.
pub const LINE_BYTES_MAX: usize = 4096;

/// Closes an ASC log, whose tools may write no line break behind it: nothing is missing.
const CLOSING: &[u8] = b"End TriggerBlock";

const UTF8_MARK: &[u8] = &[0xef, 0xbb, 0xbf];
const UTF16_MARKS: [&[u8]; 2] = [&[0xff, 0xfe], &[0xfe, 0xff]];
const UTF16: &str = "save it as UTF-8 first: `iconv -f UTF-16 -t UTF-8 LOG > NEW`";

#[derive(Debug)]
pub(super) struct Lines<R: Read> {
    input: BufReader<R>,
    line: Vec<u8>,
    number: u64,
    /// Whether the last line has no line break, and does not close the log.
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
        if self.number == 1 {
            self.begins()?;
        }
        if self.line.len() > LINE_BYTES_MAX {
            return Err(self.malformed(Defect::new("a line of at most 4096 bytes", &self.line)));
        }
        if self.line.is_empty() {
            return Ok(false);
        }
        // The cut may be anywhere, also in the white space before an event or in a comment.
        let is_whole = self.line.ends_with(b"\n") || self.text().eq_ignore_ascii_case(CLOSING);
        self.is_open = !is_whole;
        Ok(true)
    }

    /// Removes the mark of UTF-8 from the first line. In UTF-16 no line would be understood, and those of some formats would
    /// be passed over.
    fn begins(&mut self) -> Result<(), LogError> {
        if UTF16_MARKS.iter().any(|mark| self.line.starts_with(mark)) {
            let defect = Defect::new("text in UTF-8", b"UTF-16").advised(UTF16);
            return Err(self.malformed(defect));
        }
        if self.line.starts_with(UTF8_MARK) {
            self.line.drain(..UTF8_MARK.len());
        }
        Ok(())
    }

    pub(super) const fn number(&self) -> u64 {
        self.number
    }

    /// Says so if the last line is cut, as far as can be seen: half of a frame may look like a whole one.
    pub(super) fn note(&self) -> Option<String> {
        let what =
            "the last line has no line break; if the file was truncated, that line may be wrong";
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
