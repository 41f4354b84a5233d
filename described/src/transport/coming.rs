//! A message being sent to this node: its answers. The decoder reads the bytes.

use super::{ANSWER, NEXT_PACKET};
use std::collections::VecDeque;
use wire::can::CanFrame;
use wire::j1939::{Extent, Identifier, TIMED_OUT, Transport};
use wire::time::Timestamp;

#[derive(Debug, Clone)]
pub(super) struct Coming {
    /// Sender and receiver of the message.
    from: Identifier,
    extent: Extent,
    /// Maximum number of packets that the sender sends at once.
    at_once: u8,
    /// The next expected packet, and the last one granted.
    next: u8,
    granted: u8,
    due: Timestamp,
    is_over: bool,
}

impl Coming {
    pub(super) fn new(
        now: Timestamp,
        from: Identifier,
        extent: Extent,
        at_once: u8,
        ready: &mut VecDeque<CanFrame>,
    ) -> Self {
        let mut coming =
            Self { from, extent, at_once, next: 1, granted: 0, due: now, is_over: false };
        coming.grant(now, ready);
        coming
    }

    pub(super) fn is_with(&self, from: Identifier) -> bool {
        self.from.source == from.source && self.from.destination == from.destination
    }

    pub(super) const fn due(&self) -> Timestamp {
        self.due
    }

    pub(super) const fn is_over(&self) -> bool {
        self.is_over
    }

    pub(super) fn hear(&mut self, now: Timestamp, said: Transport, ready: &mut VecDeque<CanFrame>) {
        match said {
            Transport::Data { number, .. } => {
                self.due = now + NEXT_PACKET;
                if number == self.next {
                    self.next = self.next.saturating_add(1);
                }
                if self.next > self.extent.packets() {
                    self.say(Transport::Acknowledge(self.extent), ready);
                    self.is_over = true;
                } else if number >= self.granted {
                    // Grants the next packets, or repeats those after a missing one.
                    self.grant(now, ready);
                }
            }
            Transport::Abort { group, .. } if group == self.extent.group => self.is_over = true,
            _ => {}
        }
    }

    pub(super) fn give_up(&mut self, ready: &mut VecDeque<CanFrame>) {
        self.say(Transport::Abort { reason: TIMED_OUT, group: self.extent.group }, ready);
        self.is_over = true;
    }

    fn grant(&mut self, now: Timestamp, ready: &mut VecDeque<CanFrame>) {
        let left = self.extent.packets() - (self.next - 1);
        let packets = left.min(self.at_once);
        self.granted = self.next + (packets - 1);
        let group = self.extent.group;
        self.say(Transport::ClearToSend { packets, next: self.next, group }, ready);
        self.due = now + ANSWER;
    }

    fn say(&self, what: Transport, ready: &mut VecDeque<CanFrame>) {
        ready.push_back(what.encode(self.from.destination, self.from.source));
    }
}
