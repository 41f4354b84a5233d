//! A node that replays a log: it sends what was recorded, with the recorded spacing.

use described::{IsoTp, Reply, Request, UdsListener};
use plan::rig::Replayed;
use wire::device::{PortId, Transmit};
use wire::time::Timestamp;

/// A log in place of a node.
#[derive(Debug, Clone)]
pub struct Replaying {
    said: Replayed,
    next: usize,
    /// Hear how the nodes with these names are asked in the log, and what they respond.
    listeners: Vec<(String, UdsListener)>,
}

impl Replaying {
    pub(super) const fn new(said: Replayed) -> Self {
        Self { said, next: 0, listeners: Vec::new() }
    }

    /// Adds the channels on which nodes can be asked.
    pub(super) fn asking<'a>(
        mut self,
        channels: impl Iterator<Item = (&'a str, &'a IsoTp)>,
    ) -> Self {
        let listener = |(node, isotp): (&str, &IsoTp)| (node.to_owned(), UdsListener::new(isotp));
        self.listeners.extend(channels.map(listener));
        self
    }

    /// Asks for the response of a node in the log; returns `false` if it hears none.
    pub(super) fn ask(&mut self, now: Timestamp, node: &str, request: &Request) -> bool {
        let listener = self.listeners.iter_mut().find(|(name, _)| name == node);
        listener.map(|(_, listener)| listener.ask(now, request)).is_some()
    }

    pub(super) fn receive(&mut self, now: Timestamp, what: &Transmit) {
        if let Transmit::Frame(frame) = what {
            self.listeners.iter_mut().for_each(|(_, listener)| listener.receive(now, frame));
        }
    }

    pub(super) fn wake(&mut self, now: Timestamp) {
        self.listeners.iter_mut().for_each(|(_, listener)| listener.wake(now));
    }

    /// What became of a request, once.
    pub(super) fn reply(&mut self) -> Option<Reply> {
        self.listeners.iter_mut().find_map(|(_, listener)| listener.reply())
    }

    pub(super) fn next_wakeup(&self) -> Timestamp {
        let said = self.said.get(self.next);
        let due = said.map_or(Timestamp::MAX, |(at, ..)| Timestamp::ZERO + *at);
        let listeners = self.listeners.iter().map(|(_, listener)| listener.next_wakeup());
        listeners.fold(due, Timestamp::min)
    }

    /// Returns what is due by `now`, one item at a time.
    pub(super) fn transmit(&mut self, now: Timestamp) -> Option<(PortId, Transmit)> {
        let due = |(at, ..): &&(_, _, _)| Timestamp::ZERO + *at <= now;
        let (_, port, what) = self.said.get(self.next).filter(due)?;
        let (port, what) = (PortId(*port), *what);
        self.next += 1;
        self.receive(now, &what);
        Some((port, what))
    }
}
