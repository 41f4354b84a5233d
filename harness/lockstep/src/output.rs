//! Where a program's standard output and error go: always through a file, so that it never waits for a reader.

use std::fmt;
use std::fs::{File, OpenOptions};
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};
use std::process::Stdio;

/// How much of the end is quoted.
const TAIL_BYTES: u64 = 1_024;
const READ_BYTES: usize = 4_096;

/// Is given pieces of output, as they come.
pub type Hearer = dyn FnMut(&[u8]) + Send;

/// What becomes of what a program writes to its standard output and error.
#[derive(Default)]
pub enum Output {
    /// Nobody keeps it after the program's end; [`last_words`](crate::Lockstep::last_words) quotes its end.
    #[default]
    Dropped,
    /// Kept in this file, which is replaced.
    File(PathBuf),
    /// Given to somebody, in the moment of virtual time in which it was written.
    Sink(Box<Hearer>),
}

impl fmt::Debug for Output {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dropped => f.write_str("Dropped"),
            Self::File(path) => f.debug_tuple("File").field(path).finish(),
            Self::Sink(_) => f.write_str("Sink"),
        }
    }
}

/// The file, and who hears of it.
pub(crate) struct Kept {
    reader: File,
    sink: Option<Box<Hearer>>,
}

impl fmt::Debug for Kept {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Kept").field("has_sink", &self.sink.is_some()).finish()
    }
}

impl Kept {
    /// Makes the file, in `folder` where none is named; the two others are the program's.
    pub(crate) fn open(output: Output, folder: &Path) -> io::Result<(Self, Stdio, Stdio)> {
        let (path, sink) = match output {
            Output::Dropped => (folder.join("output"), None),
            Output::File(path) => (path, None),
            Output::Sink(sink) => (folder.join("output"), Some(sink)),
        };
        File::create(&path)?;
        // Appended: what the two streams write is in the order in which it was written.
        let writer = OpenOptions::new().append(true).open(&path)?;
        let kept = Self { reader: File::open(&path)?, sink };
        Ok((kept, writer.try_clone()?.into(), writer.into()))
    }

    /// Hands on what is new.
    pub(crate) fn hand_on(&mut self) {
        let Some(sink) = &mut self.sink else { return };
        let mut buffer = [0; READ_BYTES];
        while let Ok(count @ 1..) = self.reader.read(&mut buffer) {
            sink(buffer.get(..count).unwrap_or_default());
        }
    }

    /// The end of all that was written, without control characters but ends of lines.
    pub(crate) fn last_words(&self) -> String {
        let read = || {
            // A handle of its own would be a second file; the place is put back instead.
            let mut file = &self.reader;
            let place = file.stream_position()?;
            let end = file.seek(SeekFrom::End(0))?;
            file.seek(SeekFrom::Start(end.saturating_sub(TAIL_BYTES)))?;
            let mut bytes = Vec::new();
            file.take(TAIL_BYTES).read_to_end(&mut bytes)?;
            file.seek(SeekFrom::Start(place))?;
            io::Result::Ok(bytes)
        };
        let bytes = read().unwrap_or_default();
        String::from_utf8_lossy(&bytes).replace(|c: char| c.is_control() && c != '\n', "?")
    }
}
