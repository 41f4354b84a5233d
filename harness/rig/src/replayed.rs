//! A node that replays a log: it sends what was recorded, with the recorded spacing.

use described::{IsoTp, Reply, Request, UdsClient};
use plan::rig::Replayed;
use wire::device::{PortId, Transmit};
use wire::time::Timestamp;

/// A log in place of a node.
#[derive(Debug, Clone)]
pub struct Replaying {
    said: Replayed,
    next: usize,
    /// Take the responses in the log, if the plan asks the nodes with these names. Their own frames are in the log, too.
    clients: Vec<(String, UdsClient)>,
}

impl Replaying {
    pub(super) const fn new(said: Replayed) -> Self {
        Self { said, next: 0, clients: Vec::new() }
    }

    /// Adds the channels on which nodes can be asked.
    pub(super) fn asking<'a>(
        mut self,
        channels: impl Iterator<Item = (&'a str, &'a IsoTp)>,
    ) -> Self {
        let client = |(node, isotp): (&str, &IsoTp)| (node.to_owned(), UdsClient::new(isotp));
        self.clients.extend(channels.map(client));
        self
    }

    /// Waits for the response of a node; returns `false` if it hears none.
    pub(super) fn ask(&mut self, now: Timestamp, node: &str, request: &Request) -> bool {
        let client = self.clients.iter_mut().find(|(name, _)| name == node);
        client.map(|(_, client)| client.ask(now, request.clone())).is_some()
    }

    pub(super) fn receive(&mut self, now: Timestamp, what: &Transmit) {
        if let Transmit::Frame(frame) = what {
            self.clients.iter_mut().for_each(|(_, client)| client.receive(now, frame));
        }
    }

    pub(super) fn wake(&mut self, now: Timestamp) {
        for (_, client) in &mut self.clients {
            client.wake(now);
            while client.transmit().is_some() {}
        }
    }

    /// What became of a request, once.
    pub(super) fn reply(&mut self) -> Option<Reply> {
        self.clients.iter_mut().find_map(|(_, client)| client.reply())
    }

    pub(super) fn next_wakeup(&self) -> Timestamp {
        let said = self.said.get(self.next);
        let due = said.map_or(Timestamp::MAX, |(at, ..)| Timestamp::ZERO + *at);
        let clients = self.clients.iter().map(|(_, client)| client.next_wakeup());
        clients.fold(due, Timestamp::min)
    }

    /// Returns what is due by `now`, one item at a time.
    pub(super) fn transmit(&mut self, now: Timestamp) -> Option<(PortId, Transmit)> {
        let due = |(at, ..): &&(_, _, _)| Timestamp::ZERO + *at <= now;
        let (_, port, what) = self.said.get(self.next).filter(due)?;
        self.next += 1;
        Some((PortId(*port), *what))
    }
}
