//! Bus logs: the traffic of CAN buses and serial lines, in the formats of other tools.
//!
//! | [`Format`] | file | tools | resolution | serial lines |
//! |---|---|---|---|---|
//! | [`candump`] | `.log` | `candump -L`, `canplayer`, `log2asc`, python-can | 1 us | no |
//! | [`asc`] | `.asc` | Vector's tools, `asc2log`, python-can | 1 us | no |
//! | [`pcapng`] | `.pcapng` | Wireshark, tshark | 1 ns | as `LINKTYPE_USER0` |
//! | [`blf`] | `.blf` | Vector's tools, python-can | 1 ns | no |
//! | [`mdf4`] | `.mf4` | asammdf, loggers and Vector's tools | 1 ns | no |
//! | [`trc`] | `.trc` | PEAK's tools, python-can | 1 us | no |
//!
//! A reader is an iterator over [`Entry`], which ends after an error. A reader or writer holds no more than one line,
//! or a few blocks, and the names of the channels. A writer leaves out what the format cannot hold, and reports it
//! ([`Kept`]).
//!
//! [`mdf4::channels`] reads and writes measured values, which MDF files may also have.
//!
//! [`convert`] converts a file to a file, [`recorded`] the record of a run to entries, [`replay`] entries to due times;
//! [`playable`] selects the entries that a port can send.

#![allow(
    missing_docs,
    reason = "a crate of this workspace; what others use is documented where `harness` exports it"
)]

pub mod asc;
pub mod blf;
pub mod candump;
pub mod convert;
mod entry;
mod error;
mod hex;
mod lines;
pub mod mdf4;
mod numbers;
pub mod pcapng;
pub mod playable;
pub mod recorded;
pub mod replay;
#[cfg(test)]
mod tests;
pub mod trc;
mod window;

pub use entry::{CHANNEL_BYTES_MAX, Channel, Direction, Entry, ErrorFrame, Payload};
pub use error::{Defect, LogError, Place};

use record::reading::{Teller, TellingFile};
use std::fmt;
use std::fs::File;
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use wire::time::Timestamp;

const BUFFER_BYTES: usize = 64 * 1024;

wire::words! {
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Format {
        /// The log file of `candump -L` (can-utils).
        Candump = "candump",
        Asc = "asc",
        /// pcapng with `LINKTYPE_CAN_SOCKETCAN`.
        Pcapng = "pcapng",
        Trc = "trc",
        Blf = "blf",
        /// ASAM MDF 4 with bus logging.
        Mdf4 = "mdf4",
    }
}

impl Format {
    pub const fn extension(self) -> &'static str {
        match self {
            Self::Candump => "log",
            Self::Mdf4 => "mf4",
            other => other.name(),
        }
    }

    pub fn any_name() -> String {
        let [others @ .., last] = Self::NAMES;
        format!("{} or {last}", others.join(", "))
    }

    pub fn any_end() -> String {
        let [others @ .., last] = Self::ALL.map(Self::extension);
        format!(".{} or .{last}", others.join(", ."))
    }

    /// The format for the extension of a path, ignoring case.
    pub fn of_path(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?;
        Self::ALL.into_iter().find(|format| extension.eq_ignore_ascii_case(format.extension()))
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[must_use]
pub enum Kept {
    Written,
    /// The format cannot hold it.
    LeftOut,
}

trait ReadEntries: fmt::Debug {
    /// Returns the next entry; `None` at the end.
    fn read(&mut self) -> Result<Option<Entry>, LogError>;

    fn passed_over(&self) -> u64 {
        0
    }

    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
}

/// Writes one of the formats, after the head of its file.
trait WriteEntries: fmt::Debug {
    /// Appends an entry of 1970 or later.
    fn write(&mut self, entry: &Entry) -> io::Result<Kept>;

    /// The numbers of the channels so far, in a format without names.
    fn numbered(&self) -> Vec<(usize, Channel)> {
        Vec::new()
    }

    /// Writes the end of the log and flushes the file.
    fn finish(self: Box<Self>) -> io::Result<()>;
}

/// The entries of a file, in its order; ends after an error.
#[derive(Debug)]
pub struct LogReader<'r> {
    reader: Box<dyn ReadEntries + 'r>,
    entries: u64,
    ended: bool,
}

impl LogReader<'_> {
    /// Opens a file of that format.
    ///
    /// # Errors
    /// When the file cannot be opened, or does not begin like one of that format.
    pub fn open(path: &Path, format: Format) -> Result<Self, LogError> {
        Self::open_telling(path, format, Teller::default())
    }

    /// Like [`Self::open`]; `teller` shows how much of the file has been read.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn open_telling(path: &Path, format: Format, teller: Teller) -> Result<Self, LogError> {
        let file = TellingFile::open(path, teller);
        let file = file.map_err(|source| LogError::unreadable(path, source))?;
        Self::new(path, file, format)
    }
}

impl<'r> LogReader<'r> {
    /// Reads from `input`; errors name `path`.
    ///
    /// # Errors
    /// When the input does not begin like a file of that format.
    pub fn new(
        path: &Path,
        mut input: impl Read + Seek + fmt::Debug + 'r,
        format: Format,
    ) -> Result<Self, LogError> {
        // A text without lines is a log without entries, and a pipe has no length.
        let is_empty = input.seek(SeekFrom::End(0)).is_ok_and(|length| length == 0);
        if is_empty && matches!(format, Format::Pcapng | Format::Blf | Format::Mdf4) {
            return Err(LogError::Empty { path: path.to_owned(), format });
        }
        let _ = input.rewind();
        let reader: Box<dyn ReadEntries + 'r> = match format {
            Format::Candump => Box::new(candump::Reader::new(path, input)),
            Format::Asc => Box::new(asc::Reader::new(path, input)),
            Format::Pcapng => Box::new(pcapng::Reader::new(path, input)?),
            Format::Trc => Box::new(trc::Reader::new(path, input)),
            Format::Blf => Box::new(blf::Reader::new(path, input)?),
            Format::Mdf4 => Box::new(mdf4::Reader::new(path, input)?),
        };
        Ok(Self { reader, entries: 0, ended: false })
    }

    /// Number of lines, blocks, objects or records so far that are neither frames nor packets of a serial line:
    /// statistics, status, other buses, other link types.
    pub fn passed_over(&self) -> u64 {
        self.reader.passed_over()
    }

    /// Number of entries so far.
    pub const fn entries(&self) -> u64 {
        self.entries
    }

    /// What is doubtful in what has been read so far: a date that is not understood, a last line that may be cut, a file
    /// without entries.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = self.reader.notes();
        if self.ended && self.entries == 0 {
            notes.push("it has no entries".to_owned());
        }
        notes
    }
}

impl Iterator for LogReader<'_> {
    type Item = Result<Entry, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let read = self.reader.read().map_err(|error| error.after(self.entries)).transpose();
        self.ended = !matches!(read, Some(Ok(_)));
        self.entries += u64::from(!self.ended);
        read
    }
}

/// Writes a file of one of the formats. [`finish`](Self::finish) completes and flushes it.
#[derive(Debug)]
pub struct LogWriter<'w> {
    path: PathBuf,
    format: Format,
    writer: Box<dyn WriteEntries + 'w>,
}

impl LogWriter<'_> {
    /// Creates or truncates a file.
    ///
    /// # Errors
    /// When the file cannot be created.
    pub fn create(path: &Path, format: Format) -> Result<Self, LogError> {
        let file = File::create(path).map_err(|source| LogError::unwritable(path, source))?;
        Self::new(path, BufWriter::with_capacity(BUFFER_BYTES, file), format)
    }
}

impl<'w> LogWriter<'w> {
    /// Writes to `out`; errors name `path`.
    ///
    /// # Errors
    /// When the head of the file cannot be written.
    pub fn new(
        path: &Path,
        out: impl Write + Seek + fmt::Debug + 'w,
        format: Format,
    ) -> Result<Self, LogError> {
        let begun = || -> io::Result<Box<dyn WriteEntries + 'w>> {
            Ok(match format {
                Format::Candump => Box::new(candump::Writer::new(out)),
                Format::Asc => Box::new(asc::Writer::new(out)),
                Format::Pcapng => Box::new(pcapng::Writer::new(out)?),
                Format::Trc => Box::new(trc::Writer::new(out)),
                Format::Blf => Box::new(blf::Writer::new(out)?),
                Format::Mdf4 => Box::new(mdf4::Writer::new(out)?),
            })
        };
        let writer = begun().map_err(|source| LogError::unwritable(path, source))?;
        Ok(Self { path: path.to_owned(), format, writer })
    }

    /// Appends an entry.
    ///
    /// # Errors
    /// When the file cannot be written, or when the entry is from before 1970, which no format can express.
    pub fn write(&mut self, entry: &Entry) -> Result<Kept, LogError> {
        if entry.at < Timestamp::ZERO {
            return Err(LogError::Before1970 { path: self.path.clone(), format: self.format });
        }
        self.writer.write(entry).map_err(|source| LogError::unwritable(&self.path, source))
    }

    /// The numbers of the channels so far; none in a format that writes their names.
    pub fn numbered(&self) -> Vec<(usize, Channel)> {
        self.writer.numbered()
    }

    /// Writes the end of the log and flushes the file.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(self) -> Result<(), LogError> {
        self.writer.finish().map_err(|source| LogError::unwritable(&self.path, source))
    }
}
