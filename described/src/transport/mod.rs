//! Messages of J1939 that are longer than a frame: sent to everybody, or to one node that answers (SAE J1939-21, 5.10).
//!
//! A node sends one message at a time to each destination, and takes any number at once. Who only listens reads with a
//! [`Decoder`](crate::Decoder), which needs no time.

mod coming;
mod going;
mod reassembly;
#[cfg(test)]
mod tests;

pub(crate) use reassembly::{Heard, Reassembly};

use crate::layout::{Layout, Sender};
use coming::Coming;
use going::Going;
use std::collections::{BTreeSet, VecDeque};
use wire::can::CanFrame;
use wire::j1939::{self, GLOBAL, Identifier};
use wire::time::{Span, Timestamp};

/// From one packet of a message for everybody to the next: the least that the standard allows, 50 to 200 ms.
const BETWEEN_PACKETS: Span = Span::from_millis(50);
/// T1: a receiver waits so long for the next packet.
const NEXT_PACKET: Span = Span::from_millis(750);
/// T2 and T3: for the first packet behind a clear to send, and for the answer to what was sent.
const ANSWER: Span = Span::from_millis(1250);
/// T4: for more behind an answer that says to wait.
const HELD: Span = Span::from_millis(1050);
/// Messages that wait to be sent; what comes on top is dropped and counted. Assumption: as many as frames of a device.
const WAITING_MAX: usize = 64;

/// A message as it goes over the bus in parts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InParts {
    /// What a frame of its group would have for an identifier.
    pub(crate) about: Identifier,
    /// 9 to [`j1939::BYTES_MAX`] bytes.
    pub(crate) data: Box<[u8]>,
}

/// A node's end of the transport protocol.
#[derive(Debug, Clone, Default)]
pub struct Transport {
    /// The addresses that it has: those that it sends from.
    addresses: BTreeSet<u8>,
    going: Vec<Going>,
    coming: Vec<Coming>,
    ready: VecDeque<CanFrame>,
    given_up: u64,
}

impl Transport {
    /// That of whoever sends these messages of a layout; `None` where none of a layout's messages goes in parts.
    pub fn of(layout: &Layout, sender: Sender) -> Option<Box<Self>> {
        let messages = layout.messages();
        if !messages.iter().any(|message| message.is_in_parts()) {
            return None;
        }
        let sent = messages.iter().filter(|message| message.sender == sender);
        let addresses = sent.filter_map(|message| message.group()).map(|group| group.source);
        let addresses = addresses.filter(|address| *address < j1939::NULL).collect();
        Some(Box::new(Self { addresses, ..Self::default() }))
    }

    /// Forgets everything, as a device does that loses its power.
    pub fn reset(&mut self) {
        self.going.clear();
        self.coming.clear();
        self.ready.clear();
    }

    /// Sends a message, behind those that are under way to the same destination.
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

    /// A frame was on the bus.
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

    /// Does what is due.
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

    /// When to be woken, if nothing arrives before.
    pub fn next_wakeup(&self) -> Timestamp {
        let going = self.going.iter().map(Going::due);
        going.chain(self.coming.iter().map(Coming::due)).min().unwrap_or(Timestamp::MAX)
    }

    /// The next frame for the bus.
    pub fn transmit(&mut self) -> Option<CanFrame> {
        self.ready.pop_front()
    }

    /// Messages that were not sent: nobody answered in time, or too many waited.
    pub const fn given_up(&self) -> u64 {
        self.given_up
    }

    /// Takes away what is over, and begins what waited for it.
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
