//! Writes a file of measured channels.

use super::super::super::error::LogError;
use super::super::laid;
use super::super::output::{Data, Output};
use super::describe::describe;
use super::{Form, Kind, Value};
use std::collections::BTreeMap;
use std::io::{self, Seek, Write};
use std::path::{Path, PathBuf};

/// About so many bytes of records, or of texts, make a block. Each group has a buffer of that size, and each channel of
/// text: there may be hundreds of groups.
const BLOCK_BYTES: usize = 64 * 1024;

/// The most texts of one [`Kind::Choice`] channel, and names of values that are written: the format has room for 65,534.
pub(super) const CHOICES_MAX: usize = 4_096;

/// Writes an MDF file of version 4.10 with measured channels.
///
/// Groups may be added at any time. Memory is a buffer a group and a channel of text, and the texts of choices.
#[derive(Debug)]
pub struct Writer<W: Write + Seek> {
    path: PathBuf,
    out: Output<W>,
    groups: Vec<Group>,
}

/// A group of one [`Writer`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GroupId(usize);

/// A group that is written.
#[derive(Debug)]
pub(super) struct Group {
    pub(super) name: String,
    pub(super) doc: String,
    pub(super) channels: Vec<Channel>,
    pub(super) records: u64,
    data: Data,
    /// Where they are, once all are in the file.
    pub(super) data_at: u64,
}

/// A channel that is written.
#[derive(Debug)]
pub(super) struct Channel {
    pub(super) form: Form,
    /// Some of its values are missing.
    pub(super) has_gaps: bool,
    /// Texts of choices by their numbers.
    pub(super) choices: BTreeMap<String, u16>,
    texts: Data,
    /// Where the texts are, once all are in the file; zero where there are none.
    pub(super) texts_at: u64,
}

impl<W: Write + Seek> Writer<W> {
    /// Makes room for the head of the file in `out`; `path` is named in errors.
    ///
    /// # Errors
    /// When that cannot be written.
    pub fn new(path: &Path, out: W) -> Result<Self, LogError> {
        let out = Output::new(out, &laid::begin(false, 0, 0, 0, 0));
        let out = out.map_err(|source| LogError::unwritable(path, source))?;
        Ok(Self { path: path.to_owned(), out, groups: Vec::new() })
    }

    /// Adds a group. The first channel is its master, the time in seconds, and must be of [`Kind::Float`]; nothing else is
    /// written of it then.
    pub fn group(&mut self, name: &str, doc: &str, channels: Vec<Form>) -> GroupId {
        let record_bytes = record_bytes(&channels);
        let whole = (BLOCK_BYTES / record_bytes).max(1) * record_bytes;
        let channel = |form| Channel {
            form,
            has_gaps: false,
            choices: BTreeMap::new(),
            texts: Data::values(BLOCK_BYTES),
            texts_at: 0,
        };
        self.groups.push(Group {
            name: name.to_owned(),
            doc: doc.to_owned(),
            channels: channels.into_iter().map(channel).collect(),
            records: 0,
            data: Data::records(whole),
            data_at: 0,
        });
        GroupId(self.groups.len() - 1)
    }

    /// Appends a record, a value a channel. Times of a group are to ascend.
    ///
    /// # Errors
    /// When the file cannot be written; when a value is not of its channel's kind, or there are not as many as channels, or
    /// the group is of another writer.
    pub fn record(&mut self, group: GroupId, values: &[Value<'_>]) -> Result<(), LogError> {
        let unwritable = |source| LogError::unwritable(&self.path, source);
        let Some(group) = self.groups.get_mut(group.0) else {
            return Err(unwritable(misused("a group of another file")));
        };
        if values.len() != group.channels.len() {
            return Err(unwritable(misused("as many values as channels")));
        }
        let mut record = Vec::new();
        let mut invalid = vec![0_u8; values.len().div_ceil(8)];
        for (at, (channel, value)) in group.channels.iter_mut().zip(values).enumerate() {
            let is_there = channel.push(*value, &mut record, &mut self.out).map_err(unwritable)?;
            if !is_there {
                channel.has_gaps = true;
                invalid[at / 8] |= 1 << (at % 8);
            }
        }
        record.extend(invalid);
        group.records += 1;
        group.data.push(&mut self.out, |data| data.extend(record)).map_err(unwritable)
    }

    /// Writes what waits, what the channels are, and the head, and gives everything to the file. `facts` are what is known
    /// of the whole, by their names. The groups, and how many records each has.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn finish(self, facts: &[(&str, String)]) -> Result<Vec<(String, u64)>, LogError> {
        let path = self.path.clone();
        self.end(facts).map_err(|source| LogError::unwritable(&path, source))
    }

    fn end(mut self, facts: &[(&str, String)]) -> io::Result<Vec<(String, u64)>> {
        for group in &mut self.groups {
            group.data_at = group.data.finish(&mut self.out)?;
            for channel in &mut group.channels {
                channel.texts_at = channel.texts.finish(&mut self.out)?;
            }
        }
        let (begin, blocks) = describe(self.out.place(), &self.groups, facts);
        self.out.append(&blocks)?;
        self.out.finish(&begin)?;
        Ok(self.groups.into_iter().map(|group| (group.name, group.records)).collect())
    }
}

/// Bytes of a record: values, and a bit a channel that says that its value is missing.
fn record_bytes(channels: &[Form]) -> usize {
    let values: u32 = channels.iter().map(|form| form.kind.bytes()).sum();
    values as usize + channels.len().div_ceil(8)
}

fn misused(expected: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, format!("expected {expected}"))
}

impl Channel {
    /// Appends the value to a record; `false` where it is missing.
    fn push<W: Write + Seek>(
        &mut self,
        value: Value<'_>,
        record: &mut Vec<u8>,
        out: &mut Output<W>,
    ) -> io::Result<bool> {
        match (self.form.kind, value) {
            (Kind::Float, Value::Float(number)) => {
                record.extend(number.to_le_bytes());
                return Ok(!number.is_nan());
            }
            (Kind::Integer, Value::Integer(number)) => record.extend(number.to_le_bytes()),
            (Kind::Bool, Value::Bool(yes)) => record.push(u8::from(yes)),
            (Kind::Choice, Value::Text(text)) => {
                let number = self.number_of(text);
                record.extend(number.unwrap_or(0).to_le_bytes());
                return Ok(number.is_some());
            }
            (Kind::Text, Value::Text(text)) => self.push_text(text, record, out)?,
            (Kind::Float, Value::Missing) => {
                record.extend(f64::NAN.to_le_bytes());
                return Ok(false);
            }
            // It leads to a text, if to an empty one: readers follow it whatever the bit says.
            (Kind::Text, Value::Missing) => {
                self.push_text("", record, out)?;
                return Ok(false);
            }
            (kind, Value::Missing) => {
                record.resize(record.len() + kind.bytes() as usize, 0);
                return Ok(false);
            }
            (kind, value) => {
                return Err(misused(&format!("a value of {kind:?}, found {value:?}")));
            }
        }
        Ok(true)
    }

    fn push_text<W: Write + Seek>(
        &mut self,
        text: &str,
        record: &mut Vec<u8>,
        out: &mut Output<W>,
    ) -> io::Result<()> {
        record.extend(self.texts.length().to_le_bytes());
        let length = u32::try_from(text.len()).map_err(|_| misused("a text of less than 4 GB"))?;
        self.texts.push(out, |texts| {
            texts.extend(length.to_le_bytes());
            texts.extend_from_slice(text.as_bytes());
        })
    }

    /// The number of a choice; none where there are too many.
    fn number_of(&mut self, text: &str) -> Option<u16> {
        if let Some(number) = self.choices.get(text) {
            return Some(*number);
        }
        if self.choices.len() >= CHOICES_MAX {
            return None;
        }
        let number = u16::try_from(self.choices.len()).ok()?;
        self.choices.insert(text.to_owned(), number);
        Some(number)
    }
}
