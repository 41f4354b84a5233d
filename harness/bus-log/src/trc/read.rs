//! Reads a TRC file.

use super::super::entry::Entry;
use super::super::error::{Defect, LogError};
use super::super::lines::Lines;
use super::super::{Format, ReadEntries};
use super::head::Head;
use super::message;
use std::fmt;
use std::io::Read;
use std::path::Path;

/// The entries of a TRC file.
#[derive(Debug)]
pub(crate) struct Reader<R: Read> {
    lines: Lines<R>,
    head: Head,
    passed_over: u64,
}

impl<R: Read> Reader<R> {
    /// Reads from `input`; errors name `path`.
    pub(crate) fn new(path: &Path, input: R) -> Self {
        let lines = Lines::new(path, input, Format::Trc);
        Self { lines, head: Head::default(), passed_over: 0 }
    }

    fn line(&mut self) -> Result<Option<Entry>, Defect> {
        let line = self.lines.text();
        if line.is_empty() {
            return Ok(None);
        }
        if let Some(comment) = line.strip_prefix(b";") {
            self.head.take(comment)?;
            return Ok(None);
        }
        let columns = self.head.columns.as_deref();
        let columns = columns.ok_or_else(|| Defect::new("`;$COLUMNS=` before messages", line))?;
        let entry = message::parse(line, columns, self.head.began)?;
        self.passed_over += u64::from(entry.is_none());
        Ok(entry)
    }
}

impl<R: Read + fmt::Debug> ReadEntries for Reader<R> {
    fn read(&mut self) -> Result<Option<Entry>, LogError> {
        while self.lines.advance()? {
            match self.line() {
                Ok(Some(entry)) => return Ok(Some(entry)),
                Ok(None) => {}
                Err(defect) => return Err(self.lines.malformed(defect)),
            }
        }
        Ok(None)
    }

    /// Number of messages so far that are not frames of a CAN bus.
    fn passed_over(&self) -> u64 {
        self.passed_over
    }

    fn notes(&self) -> Vec<String> {
        self.lines.note().into_iter().collect()
    }
}
