//! A node that replays a log: it sends what was recorded, with the recorded spacing.

use plan::rig::Replayed;
use wire::device::{PortId, Transmit};
use wire::time::Timestamp;

/// A log in place of a node. It receives nothing.
#[derive(Debug, Clone)]
pub struct Replaying {
    said: Replayed,
    next: usize,
}

impl Replaying {
    pub(super) const fn new(said: Replayed) -> Self {
        Self { said, next: 0 }
    }

    pub(super) fn next_wakeup(&self) -> Timestamp {
        let said = self.said.get(self.next);
        said.map_or(Timestamp::MAX, |(at, ..)| Timestamp::ZERO + *at)
    }

    /// Returns what is due by `now`, one item at a time.
    pub(super) fn transmit(&mut self, now: Timestamp) -> Option<(PortId, Transmit)> {
        let due = |(at, ..): &&(_, _, _)| Timestamp::ZERO + *at <= now;
        let (_, port, what) = self.said.get(self.next).filter(due)?;
        self.next += 1;
        Some((PortId(*port), *what))
    }
}
