//! A node that replays a log: it sends what was recorded, with the recorded spacing.

use plan::rig::Replayed;
use wire::device::{PortId, Transmit};
use wire::time::Timestamp;

/// A log in place of a node. It receives nothing.
#[derive(Debug, Clone)]
pub struct Replaying {
    said: Replayed,
    next: usize,
    /// When the device that it stands for is on again, if it was switched off.
    back_at: Option<Timestamp>,
}

impl Replaying {
    pub(super) const fn new(said: Replayed) -> Self {
        Self { said, next: 0, back_at: None }
    }

    pub(super) fn next_wakeup(&self) -> Timestamp {
        let said = self.said.get(self.next);
        let speaks_at = said.map_or(Timestamp::MAX, |(at, ..)| Timestamp::ZERO + *at);
        self.back_at.map_or(speaks_at, |back_at| back_at.min(speaks_at))
    }

    /// The device is off until then. The log holds what it said meanwhile.
    pub(super) const fn cycle(&mut self, back_at: Timestamp) {
        self.back_at = Some(back_at);
    }

    /// Whether it is on again, told once.
    pub(super) fn is_back(&mut self, now: Timestamp) -> bool {
        self.back_at.take_if(|back_at| *back_at <= now).is_some()
    }

    /// Returns what is due by `now`, one item at a time.
    pub(super) fn transmit(&mut self, now: Timestamp) -> Option<(PortId, Transmit)> {
        let due = |(at, ..): &&(_, _, _)| Timestamp::ZERO + *at <= now;
        let (_, port, what) = self.said.get(self.next).filter(due)?;
        self.next += 1;
        Some((PortId(*port), *what))
    }
}
