//! Data bytes outside of their records.

use super::super::error::LogError;
use super::blocks::Source;
use super::buffered::Buffered;
use super::chain::Chain;
use std::collections::VecDeque;

/// Largest distance of a record and its data.
pub(super) const WAITING_MAX: usize = 1_024;

/// Data bytes of a frame, or of a text.
pub(super) type Bytes = Vec<u8>;

/// Signal data (`SD`): a sequence of lengths and bytes, to which records refer in ascending order.
#[derive(Debug)]
pub(super) struct SignalData {
    data: Buffered,
    most: usize,
    /// Offset of the window.
    at: u64,
    /// The last value returned, with its offset.
    last: Option<(u64, Bytes)>,
}

impl SignalData {
    /// The data at that address. Keeps at most `most` bytes of a value, for which a window has room.
    pub(super) fn new(address: u64, unfinished: bool, most: usize) -> Self {
        let data = Buffered::new(Chain::new(address, unfinished));
        Self { data, most, at: 0, last: None }
    }

    /// Start of the current block.
    pub(super) const fn began(&self) -> u64 {
        self.data.began()
    }

    pub(super) fn get(&mut self, place: u64, source: &mut Source<'_>) -> Result<Bytes, LogError> {
        if let Some((last, bytes)) = &self.last
            && *last == place
        {
            return Ok(bytes.clone());
        }
        let Some(between) = place.checked_sub(self.at) else {
            let found = format!("{place} behind {}", self.at);
            return source.bad(self.data.began(), "places of signal data that ascend", found);
        };
        let Self { data, most, .. } = self;
        let mut bytes = None;
        if data.skip(between, source)?
            && data.has(4, source)?
            && let Some(length) = data.bytes().first_chunk().copied()
        {
            let length = u64::from(u32::from_le_bytes(length));
            let known = length.min(*most as u64) as usize;
            if data.has(4 + known, source)? {
                let given = data.bytes()[4..4 + known].to_vec();
                if data.skip(4 + length, source)? {
                    self.at = place + 4 + length;
                    bytes = Some(given);
                }
            }
        }
        let Some(bytes) = bytes else {
            let found = format!("their end before {place}");
            return source.bad(self.data.began(), "signal data", found);
        };
        self.last = Some((place, bytes.clone()));
        Ok(bytes)
    }
}

/// Records of a variable-length group among the records that refer to them.
#[derive(Debug, Default)]
pub(super) struct Among {
    waiting: VecDeque<(u64, Bytes)>,
    next: u64,
}

impl Among {
    /// Takes the next record, of that length.
    pub(super) fn push(&mut self, length: u64, bytes: Bytes) {
        if self.waiting.len() == WAITING_MAX {
            self.waiting.pop_front();
        }
        self.waiting.push_back((self.next, bytes));
        self.next = self.next.saturating_add(4 + length);
    }

    /// The bytes at that offset; `None` if they have not come yet.
    pub(super) fn get(&self, place: u64) -> Option<&Bytes> {
        let found = self.waiting.iter().rev().find(|(at, _)| *at == place);
        found.map(|(_, bytes)| bytes)
    }
}
