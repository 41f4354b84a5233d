//! J1939 messages that are longer than a frame: broadcast, or sent to one node that answers (SAE J1939-21, 5.10).
//!
//! A node sends one message at a time to each destination, and receives any number at once. A pure listener uses a
//! [`Decoder`](crate::Decoder), which needs no time.

mod coming;
mod going;
mod reassembly;
#[cfg(test)]
mod tests;

pub(crate) use reassembly::{Heard, Reassembly};

use coming::Coming;
use going::Going;
use std::collections::{BTreeSet, VecDeque};
use wire::can::{CanFrame, Id};
use wire::j1939::{self, GLOBAL, Identifier};
use wire::time::{Span, Timestamp};

/// Time between two packets of a broadcast: the minimum of the standard, which allows 50 to 200 ms.
const BETWEEN_PACKETS: Span = Span::from_millis(50);
/// T1: a receiver's wait for the next packet.
const NEXT_PACKET: Span = Span::from_millis(750);
/// T2 and T3: wait for the first packet after a clear to send, and for the answer to sent packets.
const ANSWER: Span = Span::from_millis(1250);
/// T4: wait for more after an answer that requests a pause.
const HELD: Span = Span::from_millis(1050);
/// Maximum number of messages waiting to be sent; any more are dropped and counted. Assumption: as many as frames of a
/// device.
const WAITING_MAX: usize = 64;

/// A message to be sent in parts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InParts {
    /// The identifier that a single frame of its group would have.
    pub(crate) about: Identifier,
    /// 9 to [`j1939::BYTES_MAX`] bytes.
    pub(crate) data: Box<[u8]>,
}

/// A node's end of the transport protocol.
#[derive(Debug, Clone, Default)]
pub struct Transport {
    /// The node's own addresses, from which it sends.
    addresses: BTreeSet<u8>,
    going: Vec<Going>,
    coming: Vec<Coming>,
    ready: VecDeque<CanFrame>,
    given_up: u64,
}

impl Transport {
    /// The transport of a node that sends from these addresses.
    pub fn new(addresses: BTreeSet<u8>) -> Self {
        Self { addresses, ..Self::default() }
    }

    /// Discards everything, like a device that loses power.
    pub fn reset(&mut self) {
        self.going.clear();
        self.coming.clear();
        self.ready.clear();
    }

    /// Sends a message, after those in progress to the same destination.
    pub fn send(&mut self, now: Timestamp, message: InParts) {
        if self.going.len() >= WAITING_MAX {
            self.given_up += 1;
            return;
        }
        let to = message.about.destination;
        let is_busy = self.going.iter().any(|other| other.destination() == to);
        self.going.push(Going::new(message));
        if !is_busy && let Some(going) = self.going.last_mut() {
            going.begin(now, &mut self.ready);
        }
    }

    /// Whether a frame is for this node: it is for all, or for one of its addresses, as far as they are known.
    pub fn is_addressed(&self, frame: &CanFrame) -> bool {
        let Id::Extended(id) = frame.id() else { return true };
        let to = Identifier::from(id).destination;
        to == GLOBAL || self.addresses.is_empty() || self.addresses.contains(&to)
    }

    /// Takes a frame from the bus.
    pub fn receive(&mut self, now: Timestamp, frame: &CanFrame) {
        let Some((from, said)) = j1939::Transport::decode(frame) else { return };
        if from.destination == GLOBAL || !self.addresses.contains(&from.destination) {
            return;
        }
        for going in self.going.iter_mut().filter(|going| going.is_with(from)) {
            going.hear(now, said, &mut self.ready);
        }
        self.go_on(now);
        if let j1939::Transport::RequestToSend { extent, at_once } = said {
            self.coming.retain(|coming| !coming.is_with(from));
            self.coming.push(Coming::new(now, from, extent, at_once, &mut self.ready));
        }
        for coming in self.coming.iter_mut().filter(|coming| coming.is_with(from)) {
            coming.hear(now, said, &mut self.ready);
        }
        self.coming.retain(|coming| !coming.is_over());
    }

    /// Does the work due at `now`.
    pub fn wake(&mut self, now: Timestamp) {
        for going in self.going.iter_mut().filter(|going| going.due() <= now) {
            going.wake(now, &mut self.ready);
        }
        for coming in self.coming.iter_mut().filter(|coming| coming.due() <= now) {
            coming.give_up(&mut self.ready);
        }
        self.coming.retain(|coming| !coming.is_over());
        self.go_on(now);
    }

    /// Time of the next wake-up if nothing arrives before.
    pub fn next_wakeup(&self) -> Timestamp {
        let going = self.going.iter().map(Going::due);
        going.chain(self.coming.iter().map(Coming::due)).min().unwrap_or(Timestamp::MAX)
    }

    /// The next frame for the bus.
    pub fn transmit(&mut self) -> Option<CanFrame> {
        self.ready.pop_front()
    }

    /// Number of messages not sent: the receiver did not answer in time, or the queue was full.
    pub const fn given_up(&self) -> u64 {
        self.given_up
    }

    /// Removes finished messages, and starts those that waited for them.
    fn go_on(&mut self, now: Timestamp) {
        self.given_up += self.going.iter().filter(|going| going.has_failed()).count() as u64;
        self.going.retain(|going| !going.is_over());
        let mut busy = BTreeSet::new();
        for going in &mut self.going {
            if busy.insert(going.destination()) && going.is_waiting() {
                going.begin(now, &mut self.ready);
            }
        }
    }
}
