//! Writes a file of measured channels.

mod describe;

use super::super::super::error::LogError;
use super::super::laid;
use super::super::output::{Data, Output, Target};
use super::{Form, Kind, Value};
use describe::describe;
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

/// Approximate bytes of records, or of texts, in a block. Each group and each text channel has a buffer of that size,
/// and there may be hundreds of groups.
const BLOCK_BYTES: usize = 64 * 1024;

/// Most texts of one [`Kind::Choice`] channel, and most names of values that are written: the format allows 65,534.
const CHOICES_MAX: usize = 4_096;

/// Writes an MDF file of version 4.10 with measured channels.
///
/// Groups may be added at any time. Memory use is a buffer per group and per text channel, and the texts of choices.
#[derive(Debug)]
pub struct Writer<'w> {
    path: PathBuf,
    out: Output<'w>,
    groups: Vec<Group>,
}

/// A group of one [`Writer`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GroupId(usize);

#[derive(Debug)]
struct Group {
    name: String,
    doc: String,
    channels: Vec<Channel>,
    records: u64,
    data: Data,
    /// Address of the data, once written.
    data_at: u64,
}

#[derive(Debug)]
struct Channel {
    form: Form,
    /// Whether some of its values are missing.
    has_gaps: bool,
    choices: BTreeMap<String, u16>,
    texts: Data,
    /// Address of the texts, once written; zero if there are none.
    texts_at: u64,
}

impl<'w> Writer<'w> {
    /// Reserves room for the head of the file in `out`; errors name `path`.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn new(path: &Path, out: impl Target + 'w) -> Result<Self, LogError> {
        let out = Output::new(out, &laid::begin(false, 0, 0, 0, 0));
        let out = out.map_err(|source| LogError::unwritable(path, source))?;
        Ok(Self { path: path.to_owned(), out, groups: Vec::new() })
    }

    /// Adds a group. Its first channel is the master, the time in seconds, and must be of [`Kind::Float`].
    /// Nothing is written yet.
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

    /// Appends a record, with a value per channel. Times of a group must ascend.
    ///
    /// # Errors
    /// When the file cannot be written; when a value is not of its channel's type, when the number of values is wrong,
    /// or when the group belongs to another writer.
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

    /// Writes pending data, descriptions and the head, and flushes the file. `facts` describe the whole file, by name.
    /// Returns the groups with their numbers of records.
    ///
    /// # Errors
    /// When the file cannot be written.
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

/// Bytes of a record: values, and an invalidation bit per channel.
fn record_bytes(channels: &[Form]) -> usize {
    let values: u32 = channels.iter().map(|form| form.kind.bytes()).sum();
    values as usize + channels.len().div_ceil(8)
}

fn misused(expected: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, format!("expected {expected}"))
}

impl Channel {
    /// Appends the value to a record; `false` if it is missing.
    fn push(
        &mut self,
        value: Value<'_>,
        record: &mut Vec<u8>,
        out: &mut Output<'_>,
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
            // It refers to a text, even if empty: readers follow the reference whatever the bit says.
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

    fn push_text(
        &mut self,
        text: &str,
        record: &mut Vec<u8>,
        out: &mut Output<'_>,
    ) -> io::Result<()> {
        record.extend(self.texts.length().to_le_bytes());
        let length = u32::try_from(text.len()).map_err(|_| misused("a text of less than 4 GB"))?;
        self.texts.push(out, |texts| {
            texts.extend(length.to_le_bytes());
            texts.extend_from_slice(text.as_bytes());
        })
    }

    /// The number of a choice; `None` if there are too many.
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
