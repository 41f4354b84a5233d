//! The frames of one data group, in the order of the file.

use super::super::entry::Entry;
use super::super::error::{Defect, LogError};
use super::blocks::Source;
use super::buffered::Buffered;
use super::chain::Chain;
use super::frames::{Data, Frames};
use super::groups::{DataGroup, Group, Records};
use super::variable::{Among, SignalData, WAITING_MAX};
use std::collections::{HashMap, VecDeque};
use std::io::{Read, Seek};
use wire::can::FD_BYTES_MAX;

#[derive(Debug)]
pub(super) struct Stream {
    data: Buffered,
    number_bytes: usize,
    groups: Vec<Group>,
    signal_data: HashMap<u64, SignalData>,
    /// Variable-length groups by address.
    among: HashMap<u64, Among>,
    /// Frames whose data follow later, each with its group and record.
    waiting: VecDeque<(usize, Vec<u8>)>,
    began: i64,
    passed_over: u64,
}

impl Stream {
    pub(super) fn new(data: Chain, group: DataGroup, began: i64, unfinished: bool) -> Self {
        let mut among = HashMap::new();
        for group in &group.groups {
            if matches!(group.records, Records::Variable) {
                among.insert(group.address, Among::default());
            }
        }
        let mut signal_data = HashMap::new();
        for group in &group.groups {
            if let Records::Frames(_, frames) = &group.records
                && let Some(Data::Variable(_, address)) = frames.data
                && !among.contains_key(&address)
            {
                signal_data.insert(address, SignalData::new(address, unfinished, FD_BYTES_MAX));
            }
        }
        Self {
            data: Buffered::new(data),
            number_bytes: group.number_bytes,
            groups: group.groups,
            signal_data,
            among,
            waiting: VecDeque::new(),
            began,
            passed_over: 0,
        }
    }

    /// Number of records so far that are not frames.
    pub(super) const fn passed_over(&self) -> u64 {
        self.passed_over
    }

    /// Returns the next entry; `None` at the end.
    pub(super) fn next<R: Read + Seek>(
        &mut self,
        source: &mut Source<R>,
    ) -> Result<Option<Entry>, LogError> {
        loop {
            if let Some(entry) = self.first(source)? {
                return Ok(Some(entry));
            }
            if !self.data.has(self.number_bytes.max(1), source)? {
                return match self.waiting.is_empty() {
                    true => Ok(None),
                    false => Err(self.bad(source, "data bytes for every frame", "their end")),
                };
            }
            let number = self.data.number(self.number_bytes);
            let groups = &self.groups;
            let Some(index) =
                groups.iter().position(|group| self.number_bytes == 0 || group.number == number)
            else {
                let found = format!("{number}");
                return Err(self.bad(source, "the number of a group before a record", &found));
            };
            self.skip(self.number_bytes as u64, source)?;
            match &self.groups[index].records {
                Records::Frames(length, _) => {
                    let length = *length;
                    if !self.data.has(length, source)? {
                        return Err(self.cut(source));
                    }
                    self.waiting.push_back((index, self.data.bytes()[..length].to_vec()));
                    self.skip(length as u64, source)?;
                }
                Records::Variable => self.variable(index, source)?,
                Records::Other(length) => {
                    let length = *length;
                    // Records without bytes would never end.
                    if length == 0 && self.number_bytes == 0 {
                        return Err(self.bad(source, "records with bytes", "none"));
                    }
                    self.passed_over += 1;
                    self.skip(length, source)?;
                }
            }
        }
    }

    /// Returns the entry that has waited longest, if its data are there.
    fn first<R: Read + Seek>(&mut self, source: &mut Source<R>) -> Result<Option<Entry>, LogError> {
        let Some((index, record)) = self.waiting.front() else { return Ok(None) };
        let Records::Frames(_, frames) = &self.groups[*index].records else { return Ok(None) };
        let entry = match frames.data {
            Some(Data::Variable(field, address)) => {
                let place = field.number(record);
                if let Some(among) = self.among.get(&address) {
                    match among.get(place) {
                        Some(bytes) => self.entry(frames, record, Some(bytes), source)?,
                        None if self.waiting.len() <= WAITING_MAX => return Ok(None),
                        None => {
                            let found = format!("none at {place} among 1024 records");
                            return Err(self.bad(source, "data bytes near their frame", &found));
                        }
                    }
                } else {
                    let data = self.signal_data.get_mut(&address);
                    let bytes = data.map(|data| data.get(place, source)).transpose()?;
                    self.entry(frames, record, bytes.as_deref(), source)?
                }
            }
            _ => self.entry(frames, record, None, source)?,
        };
        self.waiting.pop_front();
        Ok(Some(entry))
    }

    fn entry<R: Read + Seek>(
        &self,
        frames: &Frames,
        record: &[u8],
        variable: Option<&[u8]>,
        source: &Source<R>,
    ) -> Result<Entry, LogError> {
        let entry = frames.entry(self.began, record, variable);
        entry.map_err(|defect| source.malformed(self.data.began(), defect))
    }

    /// Takes a record of a variable-length group: its length, and the bytes.
    fn variable<R: Read + Seek>(
        &mut self,
        index: usize,
        source: &mut Source<R>,
    ) -> Result<(), LogError> {
        let whole = self.data.has(4, source)?;
        let length = self.data.bytes().first_chunk().copied().map_or(0, u32::from_le_bytes);
        let known = (length as usize).min(FD_BYTES_MAX);
        if !whole || !self.data.has(4 + known, source)? {
            return Err(self.cut(source));
        }
        if let Some(among) = self.among.get_mut(&self.groups[index].address) {
            among.push(length, &self.data.bytes()[4..4 + known]);
        }
        self.skip(4 + u64::from(length), source)
    }

    fn skip<R: Read + Seek>(&mut self, count: u64, source: &mut Source<R>) -> Result<(), LogError> {
        if self.data.skip(count, source)? {
            return Ok(());
        }
        Err(self.cut(source))
    }

    fn cut<R: Read + Seek>(&self, source: &Source<R>) -> LogError {
        let defect = Defect::new("a whole record", b"the end of the data");
        source.malformed(self.data.began(), defect.cut())
    }

    fn bad<R: Read + Seek>(
        &self,
        source: &Source<R>,
        expected: &'static str,
        found: &str,
    ) -> LogError {
        source.malformed(self.data.began(), Defect::new(expected, found.as_bytes()))
    }
}
