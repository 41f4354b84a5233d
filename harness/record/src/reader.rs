//! Reads a record file as far as possible.

use super::Record;
use super::blocks::{BLOCK_BYTES, CHECK_BYTES, Check, END, NEXT, TRAILER};
use super::encoding::{MARK, PREFIX_BYTES_MAX, RECORD_BYTES_MAX, decode};
use super::header::{FORMAT_VERSION, HEADER_BYTES_MAX, Header, MAGIC, OLDEST_FORMAT_VERSION};
use super::input::Input;
use std::io::{self, Read};
use wire::time::Timestamp;

const CHECK_IS_WRONG: &str = "the block that begins here does not match its check";

/// Where a record that is cut short ends.
fn end_of(offset: u64, trailing: u64) -> String {
    match trailing {
        0 => format!("it ends at byte {offset} without its end mark"),
        _ => format!("{trailing} bytes of an incomplete record at byte {offset}"),
    }
}

/// Why a record file cannot be read, or not any further.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum RecordError {
    /// The file has a different magic.
    #[error("not a record file")]
    NotARecord,
    /// The file is from a newer harness.
    #[error("record format {found} is newer than {FORMAT_VERSION}, the newest known here")]
    #[diagnostic(help("use the version of hil that wrote it, or a later one"))]
    NewerFormat {
        /// The format's version.
        found: u16,
    },
    /// The file is from an older harness.
    #[error("record format {found} is older than {OLDEST_FORMAT_VERSION}, the oldest known here")]
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
    /// The header claims a length over the limit.
    #[error("the header claims {length} bytes")]
    HeaderTooLong {
        /// The length in the header.
        length: usize,
    },
    /// The checksum of the header is wrong.
    #[error("the header, bytes 0 to {length}, does not match its check")]
    #[diagnostic(help(
        "the file was changed since it was written; copy it again, or carry out the run again"
    ))]
    HeaderDamaged {
        /// Length of the header including its checksum.
        length: u64,
    },
    /// The block of the header is not a valid header.
    #[error("the header cannot be understood")]
    Header(#[source] serde_json::Error),
    /// The writer did not finish. All records before are valid.
    #[error("the record is cut short: {}", end_of(*offset, *trailing))]
    #[diagnostic(help(
        "the run was killed or the disk was full; all whole records were read, the last {BLOCK_BYTES} bytes at most without a check"
    ))]
    CutShort {
        /// Where the incomplete record begins, or where the end mark is missing.
        offset: u64,
        /// Bytes of the incomplete record.
        trailing: u64,
    },
    /// These bytes are not a record. All records before are valid.
    #[error("damaged at byte {offset}: {reason}")]
    #[diagnostic(help(
        "the file was changed since it was written; what stands before this place was read"
    ))]
    Damaged {
        /// Where the record begins.
        offset: u64,
        /// Description of the damage.
        reason: &'static str,
    },
    /// The file could not be read.
    #[error("failed to read the record")]
    Io(#[from] io::Error),
}

/// The records of a file, in order. An error ends the iteration. The records of a block are returned once its checksum
/// matches; those of a truncated last block have no checksum.
#[derive(Debug)]
pub struct RecordReader {
    input: Input,
    header: Header,
    /// Checksum of everything before the current block; `None` in format 2, where each record is a block.
    check: Option<Check>,
    block: Vec<u8>,
    /// Offset of the block in the file; `next`: offset of the next record in the block.
    begin: u64,
    next: usize,
    last: Timestamp,
    /// The result to return after the current block, if already known.
    behind: Option<Result<(), RecordError>>,
    ended: bool,
}

/// What was found at the end of the block being read.
enum Gathered {
    Record,
    Mark,
    /// End of the file, within or after a record.
    Nothing,
}

impl RecordReader {
    /// Reads the header.
    ///
    /// # Errors
    /// Anything but [`RecordError::CutShort`].
    pub fn new(input: impl Read + Send + 'static) -> Result<Self, RecordError> {
        let mut input = Input::new(Box::new(input));
        let (header, check) = read_header(&mut input)?;
        Ok(Self {
            begin: input.offset(),
            input,
            header,
            check,
            block: Vec::new(),
            next: 0,
            last: Timestamp::ZERO,
            behind: None,
            ended: false,
        })
    }

    /// The header of the file.
    pub const fn header(&self) -> &Header {
        &self.header
    }

    fn read(&mut self) -> Result<Option<Record>, RecordError> {
        while self.next == self.block.len() {
            match self.behind.take() {
                Some(end) => return end.map(|()| None),
                None => self.read_block()?,
            }
        }
        let (length, prefix_bytes) = length_of(&self.block[self.next..]);
        let payload = self.next + prefix_bytes;
        let record = decode(&self.block[payload..payload + length], self.last)
            .map_err(|_| self.damaged(self.next, "the bytes are no record of this format"))?;
        self.last = record.at;
        self.next = payload + length;
        Ok(Some(record))
    }

    /// Reads the records that one checksum covers, and verifies it.
    fn read_block(&mut self) -> Result<(), RecordError> {
        self.begin = self.input.offset();
        self.block.clear();
        self.next = 0;
        loop {
            let whole = self.block.len();
            match (self.gather()?, self.check) {
                (Gathered::Record, Some(_)) => {}
                (Gathered::Record, None) => return Ok(()),
                (Gathered::Mark, Some(check)) => return self.at_mark(check),
                (Gathered::Mark, None) => {
                    self.block.truncate(whole);
                    self.behind = Some(self.at_end());
                    return Ok(());
                }
                (Gathered::Nothing, _) => return self.cut_short(whole),
            }
        }
    }

    /// Appends the next record or mark to the block.
    fn gather(&mut self) -> Result<Gathered, RecordError> {
        let begin = self.block.len();
        for _ in 0..PREFIX_BYTES_MAX {
            if !self.append(1)? {
                return Ok(Gathered::Nothing);
            }
            if self.block.last().is_some_and(|byte| byte & 0x80 == 0) {
                break;
            }
        }
        let (length, prefix_bytes) = length_of(&self.block[begin..]);
        match self.block.last() {
            Some(&MARK) if prefix_bytes == 1 => return Ok(Gathered::Mark),
            // A zero in a later byte would be a second way to write the same length.
            Some(1..0x80) => {}
            _ => return Err(self.misread(begin, "a length that cannot be")),
        }
        if length > RECORD_BYTES_MAX {
            return Err(self.misread(begin, "a record longer than the longest allowed"));
        }
        // The record that fills a block ends it.
        if begin >= BLOCK_BYTES && self.check.is_some() {
            return Err(self.damaged(0, CHECK_IS_WRONG));
        }
        Ok(if self.append(length)? { Gathered::Record } else { Gathered::Nothing })
    }

    /// Verifies the checksum of the block. The first byte of a mark stands at its end.
    fn at_mark(&mut self, check: Check) -> Result<(), RecordError> {
        let records = self.block.len() - 1;
        if !self.append(1 + CHECK_BYTES)? {
            return self.cut_short(records);
        }
        let (checked, found) = self.block.split_at(records + 2);
        let check = check.of(checked);
        if check.bytes() != found {
            return Err(self.damaged(0, CHECK_IS_WRONG));
        }
        match checked.last() {
            Some(&NEXT) => {}
            Some(&END) => {
                if !self.append(TRAILER.len())? {
                    return self.cut_short(records);
                }
                if !self.block.ends_with(&TRAILER) {
                    return Err(self.damaged(records, "the end mark is another"));
                }
                self.behind = Some(self.at_end());
            }
            _ => return Err(self.damaged(records, "a mark of another format")),
        }
        self.check = Some(check);
        self.block.truncate(records);
        Ok(())
    }

    fn at_end(&mut self) -> Result<(), RecordError> {
        match self.input.append_to(&mut Vec::new(), 1)? {
            0 => Ok(()),
            _ => Err(self.damaged(self.block.len(), "there are bytes behind the end mark")),
        }
    }

    /// Handles the end of the file within the block, whose first `whole` bytes are complete records.
    fn cut_short(&mut self, whole: usize) -> Result<(), RecordError> {
        if self.check.is_some() && self.block.ends_with(&TRAILER) {
            return Err(self.damaged(0, CHECK_IS_WRONG));
        }
        let trailing = (self.block.len() - whole) as u64;
        self.block.truncate(whole);
        let offset = self.begin + whole as u64;
        self.behind = Some(Err(RecordError::CutShort { offset, trailing }));
        Ok(())
    }

    /// Appends this many bytes of the file to the block, or as many as there are; `false` if there are fewer.
    fn append(&mut self, bytes: usize) -> Result<bool, RecordError> {
        Ok(self.input.append_to(&mut self.block, bytes)? == bytes)
    }

    /// An invalid byte in a block whose checksum is not verified yet: any bit before it may be the cause.
    const fn misread(&self, place: usize, reason: &'static str) -> RecordError {
        match self.check {
            Some(_) => self.damaged(0, CHECK_IS_WRONG),
            None => self.damaged(place, reason),
        }
    }

    /// Reports damage from this place in the block on.
    const fn damaged(&self, place: usize, reason: &'static str) -> RecordError {
        RecordError::Damaged { offset: self.begin + place as u64, reason }
    }
}

impl Iterator for RecordReader {
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

/// The length at the beginning of these bytes, and the number of bytes that encode it.
fn length_of(bytes: &[u8]) -> (usize, usize) {
    let mut length = 0;
    for (index, byte) in bytes.iter().take(PREFIX_BYTES_MAX).enumerate() {
        length |= usize::from(byte & 0x7f) << (7 * index);
        if byte & 0x80 == 0 {
            return (length, index + 1);
        }
    }
    (length, PREFIX_BYTES_MAX)
}

/// Reads magic, version, block and checksum, and leaves `input` at the first record.
fn read_header(input: &mut Input) -> Result<(Header, Option<Check>), RecordError> {
    let mut bytes = vec![0; MAGIC.len()];
    read_exact(input, &mut bytes).map_err(|error| match error {
        RecordError::HeaderCutShort => RecordError::NotARecord,
        other => other,
    })?;
    if bytes != MAGIC {
        return Err(RecordError::NotARecord);
    }
    let mut version = [0; 2];
    read_exact(input, &mut version)?;
    bytes.extend(version);
    let found = u16::from_le_bytes(version);
    if found > FORMAT_VERSION {
        return Err(RecordError::NewerFormat { found });
    }
    if found < OLDEST_FORMAT_VERSION {
        return Err(RecordError::OlderFormat { found });
    }
    let mut length = [0; 4];
    read_exact(input, &mut length)?;
    bytes.extend(length);
    let length = usize::try_from(u32::from_le_bytes(length)).unwrap_or(usize::MAX);
    if length > HEADER_BYTES_MAX {
        return Err(RecordError::HeaderTooLong { length });
    }
    let block = bytes.len();
    bytes.resize(block + length, 0);
    read_exact(input, &mut bytes[block..])?;
    let mut check = None;
    if found > OLDEST_FORMAT_VERSION {
        let (of, mut written) = (Check::default().of(&bytes), [0; CHECK_BYTES]);
        read_exact(input, &mut written)?;
        if of.bytes() != written {
            return Err(RecordError::HeaderDamaged { length: input.offset() });
        }
        check = Some(Check::default());
    }
    let header = serde_json::from_slice(&bytes[block..]).map_err(RecordError::Header)?;
    Ok((header, check))
}

fn read_exact(input: &mut Input, buffer: &mut [u8]) -> Result<(), RecordError> {
    input.read_exact(buffer).map_err(|error| match error.kind() {
        io::ErrorKind::UnexpectedEof => RecordError::HeaderCutShort,
        _ => RecordError::Io(error),
    })
}
