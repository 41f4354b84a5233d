//! An outgoing message.

use super::{ANSWER, BETWEEN_PACKETS, HELD, InParts};
use std::collections::VecDeque;
use wire::can::CanFrame;
use wire::j1939::{Extent, GLOBAL, Identifier, TIMED_OUT, Transport, packet};
use wire::time::Timestamp;

#[derive(Debug, Clone)]
pub(super) struct Going {
    message: InParts,
    extent: Extent,
    /// The next packet.
    next: u8,
    state: State,
    due: Timestamp,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// Waits for another message.
    Waiting,
    /// Broadcast, one packet at a time.
    Announced,
    /// Waits for the receiver's permission.
    Asking,
    Done,
    Failed,
}

impl Going {
    pub(super) fn new(message: InParts) -> Self {
        let bytes = u16::try_from(message.data.len()).unwrap_or(u16::MAX);
        let extent = Extent { group: message.about.group, bytes };
        Self { message, extent, next: 1, state: State::Waiting, due: Timestamp::MAX }
    }

    pub(super) const fn destination(&self) -> u8 {
        self.message.about.destination
    }

    /// True if the frame is from the receiver of the message to its sender.
    pub(super) fn is_with(&self, from: Identifier) -> bool {
        self.state == State::Asking
            && from.source == self.destination()
            && from.destination == self.message.about.source
    }

    pub(super) const fn due(&self) -> Timestamp {
        self.due
    }

    pub(super) fn is_waiting(&self) -> bool {
        self.state == State::Waiting
    }

    pub(super) fn has_failed(&self) -> bool {
        self.state == State::Failed
    }

    pub(super) const fn is_over(&self) -> bool {
        matches!(self.state, State::Done | State::Failed)
    }

    pub(super) fn begin(&mut self, now: Timestamp, ready: &mut VecDeque<CanFrame>) {
        if self.destination() == GLOBAL {
            self.say(Transport::Announce(self.extent), ready);
            (self.state, self.due) = (State::Announced, now + BETWEEN_PACKETS);
        } else {
            let at_once = self.extent.packets();
            self.say(Transport::RequestToSend { extent: self.extent, at_once }, ready);
            (self.state, self.due) = (State::Asking, now + ANSWER);
        }
    }

    pub(super) fn hear(&mut self, now: Timestamp, said: Transport, ready: &mut VecDeque<CanFrame>) {
        match said {
            Transport::ClearToSend { packets: 0, group, .. } if group == self.extent.group => {
                self.due = now + HELD;
            }
            Transport::ClearToSend { packets, next, group } if group == self.extent.group => {
                let last =
                    next.saturating_add(packets.saturating_sub(1)).min(self.extent.packets());
                (next.max(1)..=last).for_each(|number| self.packet(number, ready));
                self.due = now + ANSWER;
            }
            Transport::Acknowledge(extent) if extent.group == self.extent.group => {
                (self.state, self.due) = (State::Done, Timestamp::MAX);
            }
            Transport::Abort { group, .. } if group == self.extent.group => self.fail(),
            _ => {}
        }
    }

    pub(super) fn wake(&mut self, now: Timestamp, ready: &mut VecDeque<CanFrame>) {
        match self.state {
            State::Announced => {
                self.packet(self.next, ready);
                if self.next >= self.extent.packets() {
                    (self.state, self.due) = (State::Done, Timestamp::MAX);
                } else {
                    self.next += 1;
                    self.due = now + BETWEEN_PACKETS;
                }
            }
            State::Asking => {
                let group = self.extent.group;
                self.say(Transport::Abort { reason: TIMED_OUT, group }, ready);
                self.fail();
            }
            State::Waiting | State::Done | State::Failed => {}
        }
    }

    const fn fail(&mut self) {
        (self.state, self.due) = (State::Failed, Timestamp::MAX);
    }

    fn packet(&self, number: u8, ready: &mut VecDeque<CanFrame>) {
        self.say(packet(&self.message.data, number), ready);
    }

    fn say(&self, what: Transport, ready: &mut VecDeque<CanFrame>) {
        ready.push_back(what.encode(self.message.about.source, self.destination()));
    }
}
