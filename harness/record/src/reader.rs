//! Reads a record file, as far as it goes.

use super::Record;
use super::encoding::{END_MARK, PREFIX_BYTES_MAX, RECORD_BYTES_MAX, decode};
use super::header::{FORMAT_VERSION, HEADER_BYTES_MAX, Header, MAGIC};
use std::cmp::Ordering;
use std::io::{self, BufReader, Read};
use wire::time::Timestamp;

const BUFFER_BYTES: usize = 256 * 1024;

/// Why a record file cannot be read, or no further.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum RecordError {
    /// The magic is another.
    #[error("not a record file")]
    NotARecord,
    /// A later harness wrote it.
    #[error("record format {found} is newer than {FORMAT_VERSION}, the newest known here")]
    #[diagnostic(help("use the version of hil that wrote it, or a later one"))]
    NewerFormat {
        /// The format's version.
        found: u16,
    },
    /// An earlier harness wrote it.
    #[error("record format {found} is older than {FORMAT_VERSION}, the oldest known here")]
    #[diagnostic(help(
        "use the version of hil that wrote it, or carry out the run again: hil run PLAN --seed N"
    ))]
    OlderFormat {
        /// The format's version.
        found: u16,
    },
    /// The file ends inside its header.
    #[error("the header is cut short")]
    HeaderCutShort,
    /// The header claims more than is allowed.
    #[error("the header claims {length} bytes")]
    HeaderTooLong {
        /// What it claims.
        length: usize,
    },
    /// The header's block is no header.
    #[error("the header cannot be understood")]
    Header(#[source] serde_json::Error),
    /// The writer did not come to its end. Every record before is good.
    #[error("the record is cut short: {trailing} bytes of an incomplete record at byte {offset}")]
    #[diagnostic(help("the run was killed or the disk was full; all whole records were read"))]
    CutShort {
        /// Where the incomplete record begins, or where the end mark is missing.
        offset: u64,
        /// Bytes there are of it.
        trailing: u64,
    },
    /// Bytes that are no record. Every record before is good.
    #[error("damaged at byte {offset}: {reason}")]
    Damaged {
        /// Where the record begins.
        offset: u64,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// The file could not be read.
    #[error("failed to read the record")]
    Io(#[from] io::Error),
}

/// The records of a file, in order. After an error there are no more.
#[derive(Debug)]
pub struct RecordReader<R: Read> {
    input: BufReader<R>,
    header: Header,
    payload: Vec<u8>,
    last: Timestamp,
    offset: u64,
    ended: bool,
}

enum Filled {
    Whole,
    Short(usize),
}

impl<R: Read> RecordReader<R> {
    /// Reads the header.
    ///
    /// # Errors
    /// Anything but [`RecordError::CutShort`] and [`RecordError::Damaged`].
    pub fn new(input: R) -> Result<Self, RecordError> {
        let mut input = Counted { input: BufReader::with_capacity(BUFFER_BYTES, input), bytes: 0 };
        let header = read_header(&mut input)?;
        Ok(Self {
            offset: input.bytes,
            input: input.input,
            header,
            payload: Vec::new(),
            last: Timestamp::ZERO,
            ended: false,
        })
    }

    /// What the file says about itself.
    pub const fn header(&self) -> &Header {
        &self.header
    }

    fn read(&mut self) -> Result<Option<Record>, RecordError> {
        let (length, prefix_bytes) = match self.length()? {
            (0, _) => return self.at_end_mark(),
            other => other,
        };
        self.payload.resize(length, 0);
        match fill(&mut self.input, &mut self.payload)? {
            Filled::Whole => {}
            Filled::Short(bytes) => return Err(self.cut_short(prefix_bytes + bytes)),
        }
        let record = decode(&self.payload, self.last)
            .map_err(|_| self.damaged("the bytes are no record of this format"))?;
        self.last = record.at;
        self.offset += (prefix_bytes + length) as u64;
        Ok(Some(record))
    }

    /// The next record's length, and how many bytes it took to say so.
    fn length(&mut self) -> Result<(usize, usize), RecordError> {
        let mut length = 0;
        for index in 0..PREFIX_BYTES_MAX {
            let mut byte = [0];
            if let Filled::Short(_) = fill(&mut self.input, &mut byte)? {
                return Err(self.cut_short(index));
            }
            length |= usize::from(byte[0] & 0x7f) << (7 * index);
            if byte[0] & 0x80 == 0 {
                // A zero in a later byte would be a second way to write the same length.
                if byte[0] == 0 && index > 0 {
                    break;
                }
                if length > RECORD_BYTES_MAX {
                    return Err(self.damaged("a record longer than the longest allowed"));
                }
                return Ok((length, index + 1));
            }
        }
        Err(self.damaged("a length that cannot be"))
    }

    fn at_end_mark(&mut self) -> Result<Option<Record>, RecordError> {
        match fill(&mut self.input, &mut [END_MARK])? {
            Filled::Short(_) => Ok(None),
            Filled::Whole => Err(self.damaged("there are bytes behind the end mark")),
        }
    }

    const fn cut_short(&self, trailing: usize) -> RecordError {
        RecordError::CutShort { offset: self.offset, trailing: trailing as u64 }
    }

    const fn damaged(&self, reason: &'static str) -> RecordError {
        RecordError::Damaged { offset: self.offset, reason }
    }
}

impl<R: Read> Iterator for RecordReader<R> {
    type Item = Result<Record, RecordError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let read = self.read().transpose();
        self.ended = !matches!(read, Some(Ok(_)));
        read
    }
}

/// Fills `buffer`, and tells how far it came where the input ends before.
fn fill(input: &mut impl Read, buffer: &mut [u8]) -> io::Result<Filled> {
    let mut filled = 0;
    while filled < buffer.len() {
        match input.read(&mut buffer[filled..]) {
            Ok(0) => return Ok(Filled::Short(filled)),
            Ok(bytes) => filled += bytes,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(Filled::Whole)
}

/// Counts what is read through it: offsets in errors are those of the file.
struct Counted<R> {
    input: R,
    bytes: u64,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let bytes = self.input.read(buffer)?;
        self.bytes += bytes as u64;
        Ok(bytes)
    }
}

/// Reads magic, version and block, and leaves `input` at the first record.
fn read_header(input: &mut impl Read) -> Result<Header, RecordError> {
    let mut magic = [0; MAGIC.len()];
    read_exact(input, &mut magic).map_err(|error| match error {
        RecordError::HeaderCutShort => RecordError::NotARecord,
        other => other,
    })?;
    if magic != MAGIC {
        return Err(RecordError::NotARecord);
    }
    let mut version = [0; 2];
    read_exact(input, &mut version)?;
    let found = u16::from_le_bytes(version);
    match found.cmp(&FORMAT_VERSION) {
        Ordering::Greater => return Err(RecordError::NewerFormat { found }),
        Ordering::Less => return Err(RecordError::OlderFormat { found }),
        Ordering::Equal => {}
    }
    let mut length = [0; 4];
    read_exact(input, &mut length)?;
    let length = usize::try_from(u32::from_le_bytes(length)).unwrap_or(usize::MAX);
    if length > HEADER_BYTES_MAX {
        return Err(RecordError::HeaderTooLong { length });
    }
    let mut block = vec![0; length];
    read_exact(input, &mut block)?;
    serde_json::from_slice(&block).map_err(RecordError::Header)
}

fn read_exact(input: &mut impl Read, buffer: &mut [u8]) -> Result<(), RecordError> {
    input.read_exact(buffer).map_err(|error| match error.kind() {
        io::ErrorKind::UnexpectedEof => RecordError::HeaderCutShort,
        _ => RecordError::Io(error),
    })
}
