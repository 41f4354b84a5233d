//! The frames of one data group, in the order of the file.

use super::super::entry::Entry;
use super::super::error::{Defect, LogError};
use super::blocks::Source;
use super::chain::Chain;
use super::frames::{Data, Frames};
use super::groups::{DataGroup, Group, RECORD_BYTES_MAX, Records};
use super::unsorted::Unsorted;
use super::variable::{Among, SignalData, WAITING_MAX};
use std::collections::{HashMap, VecDeque};
use wire::can::FD_BYTES_MAX;

#[derive(Debug)]
pub(super) struct Stream {
    data: Unsorted,
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
            if let Records::Frames(frames) = &group.records
                && let Some(Data::Variable(_, address)) = frames.data
                && !among.contains_key(&address)
            {
                signal_data.insert(address, SignalData::new(address, unfinished, FD_BYTES_MAX));
            }
        }
        Self {
            data: Unsorted::new(data, group.number_bytes, group.lengths),
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
    pub(super) fn next(&mut self, source: &mut Source<'_>) -> Result<Option<Entry>, LogError> {
        loop {
            if let Some(entry) = self.first(source)? {
                return Ok(Some(entry));
            }
            let Some((index, length)) = self.data.next(source)? else {
                let missing = Defect::new("data bytes for every frame", b"their end");
                let is_whole = self.waiting.is_empty();
                return if is_whole { Ok(None) } else { Err(self.data.malformed(missing, source)) };
            };
            let group = &self.groups[index];
            match group.records {
                Records::Frames(_) => {
                    let record = self.data.take(length, RECORD_BYTES_MAX, source)?;
                    self.waiting.push_back((index, record));
                }
                Records::Variable => {
                    let bytes = self.data.take(length, FD_BYTES_MAX, source)?;
                    if let Some(among) = self.among.get_mut(&group.address) {
                        among.push(length, bytes);
                    }
                }
                Records::Other => {
                    self.passed_over += 1;
                    self.data.skip(length, source)?;
                }
            }
        }
    }

    /// Returns the entry that has waited longest, if its data are there.
    fn first(&mut self, source: &mut Source<'_>) -> Result<Option<Entry>, LogError> {
        let Some((index, record)) = self.waiting.front() else { return Ok(None) };
        let Records::Frames(frames) = &self.groups[*index].records else { return Ok(None) };
        let entry = match frames.data {
            Some(Data::Variable(field, address)) => {
                let place = field.number(record);
                if let Some(among) = self.among.get(&address) {
                    match among.get(place) {
                        Some(bytes) => self.entry(frames, record, Some(bytes), source)?,
                        None if self.waiting.len() <= WAITING_MAX => return Ok(None),
                        None => {
                            let found = format!("none at {place} among 1024 records");
                            let defect = Defect::new("data bytes near their frame", found);
                            return Err(self.data.malformed(defect, source));
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

    fn entry(
        &self,
        frames: &Frames,
        record: &[u8],
        variable: Option<&[u8]>,
        source: &Source<'_>,
    ) -> Result<Entry, LogError> {
        let entry = frames.entry(self.began, record, variable);
        entry.map_err(|defect| self.data.malformed(defect, source))
    }
}
