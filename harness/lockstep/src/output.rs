//! Destination of a program's standard output and error: always a file first, so that the program never waits for a
//! reader.

use std::fmt;
use std::fs::{File, OpenOptions};
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::process::Stdio;

/// Bytes of the end that are quoted.
const TAIL_BYTES: u64 = 1_024;
const READ_BYTES: usize = 4_096;
/// Bytes of the beginning that stay in the file, as of a program in real time.
const KEPT_BYTES: u64 = 16 * 1_024 * 1_024;
/// The file may be this much longer for a while.
const EXCESS_BYTES: u64 = 1_024 * 1_024;
const CUT: &[u8] = b"\n[not all of it was kept]\n";

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
    /// Kept in this file, behind what it holds already.
    Appended(PathBuf),
    /// Passed to a function, at the instant of virtual time in which it was written.
    Sink(Box<Hearer>),
}

impl fmt::Debug for Output {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dropped => f.write_str("Dropped"),
            Self::File(path) => f.debug_tuple("File").field(path).finish(),
            Self::Appended(path) => f.debug_tuple("Appended").field(path).finish(),
            Self::Sink(_) => f.write_str("Sink"),
        }
    }
}

/// The file, and the receiver of its contents.
pub(crate) struct Kept {
    reader: File,
    writer: File,
    sink: Option<Box<Hearer>>,
    /// The end of what was cut off.
    cut: Vec<u8>,
}

impl fmt::Debug for Kept {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Kept").field("has_sink", &self.sink.is_some()).finish()
    }
}

impl Kept {
    /// Creates the file, in `folder` if none is named; the other two results are for the program.
    pub(crate) fn open(output: Output, folder: &Path) -> io::Result<(Self, Stdio, Stdio)> {
        let is_replaced = !matches!(output, Output::Appended(_));
        let (path, sink) = match output {
            Output::Dropped => (folder.join("output"), None),
            Output::File(path) | Output::Appended(path) => (path, None),
            Output::Sink(sink) => (folder.join("output"), Some(sink)),
        };
        if is_replaced {
            File::create(&path)?;
        }
        // Append mode keeps both streams in the order of writing.
        let writer = OpenOptions::new().append(true).create(true).open(&path)?;
        let reader = File::open(&path)?;
        let streams = (writer.try_clone()?.into(), writer.try_clone()?.into());
        let kept = Self { reader, writer, sink, cut: Vec::new() };
        Ok((kept, streams.0, streams.1))
    }

    /// Passes on what was written, and keeps the file short; called at each stop of the program and at its end.
    pub(crate) fn hand_on(&mut self) {
        if let Some(sink) = &mut self.sink {
            let mut buffer = [0; READ_BYTES];
            while let Ok(count @ 1..) = self.reader.read(&mut buffer) {
                sink(buffer.get(..count).unwrap_or_default());
            }
        }
        // Without the disk's answer the output stays as long as it is.
        let _ = self.shorten(KEPT_BYTES, EXCESS_BYTES);
    }

    /// Cuts the file to `kept` bytes and a remark once it is longer by `excess`; a passed-on beginning need not stay.
    fn shorten(&mut self, kept: u64, excess: u64) -> io::Result<()> {
        if self.writer.metadata()?.len() <= kept + excess {
            return Ok(());
        }
        self.cut = self.tail();
        self.writer.set_len(if self.sink.is_some() { 0 } else { kept })?;
        (&self.writer).write_all(CUT)?;
        if self.sink.is_some() {
            self.reader.seek(SeekFrom::End(0))?;
        }
        Ok(())
    }

    /// The last bytes of the file.
    fn end(&self) -> io::Result<Vec<u8>> {
        // A cloned handle would share the position, so the position is restored instead.
        let mut file = &self.reader;
        let place = file.stream_position()?;
        let end = file.seek(SeekFrom::End(0))?;
        file.seek(SeekFrom::Start(end.saturating_sub(TAIL_BYTES)))?;
        let mut bytes = Vec::new();
        file.take(TAIL_BYTES).read_to_end(&mut bytes)?;
        file.seek(SeekFrom::Start(place))?;
        Ok(bytes)
    }

    /// The last bytes that were written.
    fn tail(&self) -> Vec<u8> {
        let mut bytes = self.end().unwrap_or_default();
        // After a cut, what follows the remark continues what was cut off.
        if let Some(place) = bytes.windows(CUT.len()).rposition(|bytes| bytes == CUT) {
            bytes.splice(..place + CUT.len(), self.cut.iter().copied());
        }
        bytes.split_off(bytes.len().saturating_sub(TAIL_BYTES as usize))
    }

    /// The end of the output, without control characters except line endings.
    pub(crate) fn last_words(&self) -> String {
        let tail = self.tail();
        String::from_utf8_lossy(&tail).replace(|c: char| c.is_control() && c != '\n', "?")
    }
}

#[cfg(test)]
mod tests {
    use super::{EXCESS_BYTES, KEPT_BYTES, Kept, Output};
    use std::fs;
    use std::io::Write as _;
    use std::sync::{Arc, Mutex};

    #[test]
    fn the_beginning_stays_and_the_end_is_quoted() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log");
        let (mut kept, ..) = Kept::open(Output::File(path.clone()), folder.path()).unwrap();
        for line in 0..100 {
            writeln!(kept.writer, "line {line:03}").unwrap();
            kept.shorten(45, 90).unwrap();
        }
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.len() <= 45 + 90, "{text}");
        assert!(text.starts_with("line 000\nline 001"), "{text}");
        assert!(text.contains("[not all of it was kept]"), "{text}");
        let last = kept.last_words();
        assert!(last.ends_with("line 098\nline 099\n"), "{last}");
        assert!(!last.contains("was kept"), "{last}");
    }

    /// Found by a user: a program that printed without end and never waited left 400 MB.
    #[test]
    fn what_was_written_without_a_stop_is_cut_at_the_next() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log");
        let (mut kept, ..) = Kept::open(Output::File(path.clone()), folder.path()).unwrap();
        let bytes = vec![b'x'; usize::try_from(KEPT_BYTES + EXCESS_BYTES + 1).unwrap()];
        kept.writer.write_all(&bytes).unwrap();
        kept.hand_on();
        let kept = fs::metadata(path).unwrap().len();
        assert!(kept < KEPT_BYTES + EXCESS_BYTES, "{kept} bytes");
    }

    #[test]
    fn what_was_passed_on_need_not_stay() {
        let folder = tempfile::tempdir().unwrap();
        let heard: Arc<Mutex<Vec<u8>>> = Arc::default();
        let hearer = Arc::clone(&heard);
        let sink = move |bytes: &[u8]| hearer.lock().unwrap().extend(bytes);
        let (mut kept, ..) = Kept::open(Output::Sink(Box::new(sink)), folder.path()).unwrap();
        let mut sent = Vec::new();
        for line in 0..100 {
            writeln!(sent, "line {line:03}").unwrap();
            writeln!(kept.writer, "line {line:03}").unwrap();
            kept.hand_on();
            kept.shorten(45, 90).unwrap();
        }
        assert!(fs::metadata(folder.path().join("output")).unwrap().len() <= 45 + 90);
        assert_eq!(*heard.lock().unwrap(), sent);
    }
}
