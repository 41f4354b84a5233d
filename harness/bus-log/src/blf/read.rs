//! Reads a BLF file.

use super::super::ReadEntries;
use super::super::entry::Entry;
use super::super::error::{Defect, LogError};
use super::super::window::Window;
use super::containers::{Containers, PADDING_MAX};
use super::object::{self, OBJECT_BYTES_MAX};
use super::{APP_TEXT, BEGAN_AT, OBJECT_BASE_BYTES, OBJECT_MARK, date};
use std::fmt;
use std::io::Read;
use std::path::Path;

/// The entries of a BLF file.
#[derive(Debug)]
pub(crate) struct Reader<R: Read> {
    containers: Containers<R>,
    window: Window,
    /// Start of the measurement, nanoseconds since 1970.
    began: i64,
    passed_over: u64,
}

impl<R: Read> Reader<R> {
    /// Reads from `input`; errors name `path`.
    pub(crate) fn new(path: &Path, input: R) -> Result<Self, LogError> {
        let (containers, head) = Containers::new(path, input)?;
        let began = head[BEGAN_AT..].first_chunk().and_then(date::parse).unwrap_or(0);
        Ok(Self { containers, window: Window::new(), began, passed_over: 0 })
    }

    /// Advances to the next object, with its base in the buffer; `false` at the end of the last container.
    fn find(&mut self) -> Result<bool, LogError> {
        let whole = self.has(OBJECT_BASE_BYTES + PADDING_MAX)?;
        let rest = self.window.bytes();
        let near = &rest[..rest.len().min(OBJECT_MARK.len() + PADDING_MAX)];
        if let Some(padding) = near.windows(OBJECT_MARK.len()).position(|near| near == OBJECT_MARK)
        {
            self.skip(padding as u32)?;
            return if self.has(OBJECT_BASE_BYTES)? { Ok(true) } else { Err(self.cut()) };
        }
        if !whole && rest.len() <= PADDING_MAX && !rest.contains(&OBJECT_MARK[0]) {
            return Ok(false);
        }
        let defect = Defect::new("an object that begins with `LOBJ`", near);
        Err(self.containers.malformed(defect))
    }

    fn has(&mut self, count: usize) -> Result<bool, LogError> {
        self.window.has(count, |out| self.containers.read(out))
    }

    fn skip(&mut self, count: u32) -> Result<(), LogError> {
        let skipped = self.window.skip(u64::from(count), |out| self.containers.read(out))?;
        if skipped { Ok(()) } else { Err(self.cut()) }
    }

    fn cut(&self) -> LogError {
        let defect = Defect::new("a whole object", b"the end of the last container");
        self.containers.malformed(defect.cut())
    }
}

impl<R: Read + fmt::Debug> ReadEntries for Reader<R> {
    fn read(&mut self) -> Result<Option<Entry>, LogError> {
        while self.find()? {
            let base = self.window.bytes();
            let word = |place: usize| base[place..].first_chunk().copied().map(u32::from_le_bytes);
            let (Some(length), Some(kind)) = (word(8), word(12)) else { return Ok(None) };
            if (length as usize) < OBJECT_BASE_BYTES {
                let found = format!("{length} bytes");
                let defect = Defect::new("an object of at least 16 bytes", found);
                return Err(self.containers.malformed(defect));
            }
            if !object::is_of_can(kind) {
                // A comment is not a part of the traffic.
                self.passed_over += u64::from(kind != APP_TEXT);
                self.skip(length)?;
                continue;
            }
            let known = (length as usize).min(OBJECT_BYTES_MAX);
            if !self.has(known)? {
                return Err(self.cut());
            }
            let entry = object::parse(kind, &self.window.bytes()[..known], self.began);
            let entry = entry.map_err(|defect| self.containers.malformed(defect))?;
            self.skip(length)?;
            if entry.is_some() {
                return Ok(entry);
            }
            self.passed_over += 1;
        }
        Ok(None)
    }

    /// Number of objects so far that are not frames of a CAN bus.
    fn passed_over(&self) -> u64 {
        self.passed_over + self.containers.passed_over()
    }
}
