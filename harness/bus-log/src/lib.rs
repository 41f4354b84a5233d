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
use std::fs::File;
use std::io::{BufWriter, Read, Seek, Write};
use std::path::Path;

const BUFFER_BYTES: usize = 64 * 1024;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// The log file of `candump -L` (can-utils).
    Candump,
    Asc,
    /// pcapng with `LINKTYPE_CAN_SOCKETCAN`.
    Pcapng,
    Trc,
    Blf,
    /// ASAM MDF 4 with bus logging.
    Mdf4,
}

impl Format {
    pub const ALL: [Self; 6] =
        [Self::Candump, Self::Asc, Self::Pcapng, Self::Trc, Self::Blf, Self::Mdf4];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Candump => "candump",
            Self::Asc => "asc",
            Self::Pcapng => "pcapng",
            Self::Trc => "trc",
            Self::Blf => "blf",
            Self::Mdf4 => "mdf4",
        }
    }

    pub const fn extension(self) -> &'static str {
        match self {
            Self::Candump => "log",
            Self::Asc => "asc",
            Self::Pcapng => "pcapng",
            Self::Trc => "trc",
            Self::Blf => "blf",
            Self::Mdf4 => "mf4",
        }
    }

    pub fn any_name() -> String {
        let [others @ .., last] = Self::ALL.map(Self::name);
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

/// The entries of a file, in its order; ends after an error.
#[derive(Debug)]
pub struct LogReader<R: Read + Seek = TellingFile> {
    reader: Reader<R>,
    ended: bool,
}

/// Readers that hold more than a line are boxed.
#[derive(Debug)]
enum Reader<R: Read + Seek> {
    Candump(candump::Reader<R>),
    Asc(Box<asc::Reader<R>>),
    Pcapng(Box<pcapng::Reader<R>>),
    Trc(Box<trc::Reader<R>>),
    Blf(Box<blf::Reader<R>>),
    Mdf4(Box<mdf4::Reader<R>>),
}

impl LogReader {
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

impl<R: Read + Seek> LogReader<R> {
    /// Reads from `input`; errors name `path`.
    ///
    /// # Errors
    /// When the input does not begin like a file of that format.
    pub fn new(path: &Path, input: R, format: Format) -> Result<Self, LogError> {
        let reader = match format {
            Format::Candump => Reader::Candump(candump::Reader::new(path, input)),
            Format::Asc => Reader::Asc(Box::new(asc::Reader::new(path, input))),
            Format::Pcapng => Reader::Pcapng(Box::new(pcapng::Reader::new(path, input)?)),
            Format::Trc => Reader::Trc(Box::new(trc::Reader::new(path, input))),
            Format::Blf => Reader::Blf(Box::new(blf::Reader::new(path, input)?)),
            Format::Mdf4 => Reader::Mdf4(Box::new(mdf4::Reader::new(path, input)?)),
        };
        Ok(Self { reader, ended: false })
    }

    /// Number of lines, blocks, objects or records so far that are neither frames nor packets of a serial line:
    /// statistics, status, other buses, other link types.
    pub fn passed_over(&self) -> u64 {
        match &self.reader {
            Reader::Candump(_) => 0,
            Reader::Asc(reader) => reader.passed_over(),
            Reader::Pcapng(reader) => reader.passed_over(),
            Reader::Trc(reader) => reader.passed_over(),
            Reader::Blf(reader) => reader.passed_over(),
            Reader::Mdf4(reader) => reader.passed_over(),
        }
    }

    /// What is doubtful in what has been read so far: a date that is not understood, a last line that may be cut.
    pub fn notes(&self) -> Vec<String> {
        match &self.reader {
            Reader::Candump(reader) => reader.note().into_iter().collect(),
            Reader::Asc(reader) => reader.notes(),
            Reader::Trc(reader) => reader.note().into_iter().collect(),
            Reader::Pcapng(_) | Reader::Blf(_) | Reader::Mdf4(_) => Vec::new(),
        }
    }
}

impl<R: Read + Seek> Iterator for LogReader<R> {
    type Item = Result<Entry, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let read = match &mut self.reader {
            Reader::Candump(reader) => reader.read(),
            Reader::Asc(reader) => reader.read(),
            Reader::Pcapng(reader) => reader.read(),
            Reader::Trc(reader) => reader.read(),
            Reader::Blf(reader) => reader.read(),
            Reader::Mdf4(reader) => reader.read(),
        };
        let read = read.transpose();
        self.ended = !matches!(read, Some(Ok(_)));
        read
    }
}

/// Writes a file of one of the formats. [`finish`](Self::finish) completes and flushes it.
#[derive(Debug)]
pub enum LogWriter<W: Write + Seek = BufWriter<File>> {
    Candump(candump::Writer<W>),
    Asc(asc::Writer<W>),
    Pcapng(pcapng::Writer<W>),
    Trc(trc::Writer<W>),
    Blf(blf::Writer<W>),
    Mdf4(mdf4::Writer<W>),
}

impl LogWriter {
    /// Creates or truncates a file.
    ///
    /// # Errors
    /// When the file cannot be created.
    pub fn create(path: &Path, format: Format) -> Result<Self, LogError> {
        let file = File::create(path).map_err(|source| LogError::unwritable(path, source))?;
        Self::new(path, BufWriter::with_capacity(BUFFER_BYTES, file), format)
    }
}

impl<W: Write + Seek> LogWriter<W> {
    /// Writes to `out`; errors name `path`.
    ///
    /// # Errors
    /// When the head of the file cannot be written.
    pub fn new(path: &Path, out: W, format: Format) -> Result<Self, LogError> {
        Ok(match format {
            Format::Candump => Self::Candump(candump::Writer::new(path, out)),
            Format::Asc => Self::Asc(asc::Writer::new(path, out)),
            Format::Pcapng => Self::Pcapng(pcapng::Writer::new(path, out)?),
            Format::Trc => Self::Trc(trc::Writer::new(path, out)),
            Format::Blf => Self::Blf(blf::Writer::new(path, out)?),
            Format::Mdf4 => Self::Mdf4(mdf4::Writer::new(path, out)?),
        })
    }

    /// Appends an entry.
    ///
    /// # Errors
    /// When the file cannot be written, or when the format cannot express the time.
    pub fn write(&mut self, entry: &Entry) -> Result<Kept, LogError> {
        match self {
            Self::Candump(writer) => writer.write(entry),
            Self::Asc(writer) => writer.write(entry),
            Self::Pcapng(writer) => writer.write(entry),
            Self::Trc(writer) => writer.write(entry),
            Self::Blf(writer) => writer.write(entry),
            Self::Mdf4(writer) => writer.write(entry),
        }
    }

    /// Writes the end of the log and flushes the file.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(self) -> Result<(), LogError> {
        match self {
            Self::Candump(writer) => writer.finish(),
            Self::Asc(writer) => writer.finish(),
            Self::Pcapng(writer) => writer.finish(),
            Self::Trc(writer) => writer.finish(),
            Self::Blf(writer) => writer.finish(),
            Self::Mdf4(writer) => writer.finish(),
        }
    }
}
