//! Counts frames by their identifier.

use std::collections::BTreeMap;
use std::fmt;
use wire::can::{Hex, Id};

/// Most identifiers that are counted one by one. Assumption: nobody reads more of them.
const IDENTIFIERS_MAX: usize = 16;

/// Numbers of frames: `0x123 (4), 0x7ff (1), and 3 with others`.
#[derive(Debug, Clone, Default)]
pub struct Identifiers {
    frames: BTreeMap<Id, u64>,
    /// Frames with further identifiers.
    more: u64,
}

impl Identifiers {
    /// Counts a frame.
    #[cold]
    pub fn count(&mut self, id: Id) {
        let is_full = self.frames.len() == IDENTIFIERS_MAX;
        match self.frames.get_mut(&id) {
            Some(frames) => *frames += 1,
            None if is_full => self.more += 1,
            None => _ = self.frames.insert(id, 1),
        }
    }

    /// Takes out the count of each identifier for which `is_one` holds.
    pub fn take(&mut self, is_one: impl Fn(Id) -> bool) -> Vec<(Id, u64)> {
        let taken: Vec<_> =
            self.frames.iter().filter(|(id, _)| is_one(**id)).map(|(id, n)| (*id, *n)).collect();
        self.frames.retain(|id, _| !is_one(*id));
        taken
    }

    /// The identifiers that are counted one by one, with their counts.
    pub fn each(&self) -> impl Iterator<Item = (Id, u64)> {
        self.frames.iter().map(|(id, count)| (*id, *count))
    }

    /// True if nothing was counted.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty() && self.more == 0
    }
}

impl fmt::Display for Identifiers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let each: Vec<_> =
            self.each().map(|(id, count)| format!("{} ({count})", Hex(id))).collect();
        f.write_str(&each.join(", "))?;
        match self.more {
            0 => Ok(()),
            more => write!(f, ", and {more} with others"),
        }
    }
}
