//! Destination of a program's standard output and error: always a file first, so that the program never waits for a
//! reader.

use std::fmt;
use std::fs::{File, OpenOptions};
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};
use std::process::Stdio;

/// Bytes of the end that are quoted.
const TAIL_BYTES: u64 = 1_024;
const READ_BYTES: usize = 4_096;

/// Receives pieces of output as they come.
pub type Hearer = dyn FnMut(&[u8]) + Send;

/// Destination of a program's standard output and error.
#[derive(Default)]
pub enum Output {
    /// Discarded at the program's end; [`last_words`](crate::Lockstep::last_words) quotes the end of it.
    #[default]
    Dropped,
    /// Kept in this file, which is replaced.
    File(PathBuf),
    /// Passed to a function, at the instant of virtual time in which it was written.
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

/// The file, and the receiver of its contents.
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
    /// Creates the file, in `folder` if none is named; the other two results are for the program.
    pub(crate) fn open(output: Output, folder: &Path) -> io::Result<(Self, Stdio, Stdio)> {
        let (path, sink) = match output {
            Output::Dropped => (folder.join("output"), None),
            Output::File(path) => (path, None),
            Output::Sink(sink) => (folder.join("output"), Some(sink)),
        };
        File::create(&path)?;
        // Append mode keeps both streams in the order of writing.
        let writer = OpenOptions::new().append(true).open(&path)?;
        let kept = Self { reader: File::open(&path)?, sink };
        Ok((kept, writer.try_clone()?.into(), writer.into()))
    }

    pub(crate) fn hand_on(&mut self) {
        let Some(sink) = &mut self.sink else { return };
        let mut buffer = [0; READ_BYTES];
        while let Ok(count @ 1..) = self.reader.read(&mut buffer) {
            sink(buffer.get(..count).unwrap_or_default());
        }
    }

    /// The end of the output, without control characters except line endings.
    pub(crate) fn last_words(&self) -> String {
        let read = || {
            // A cloned handle would share the position, so the position is restored instead.
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
