//! What a node sends, until the line takes it.

use crate::layout::{EncodeError, Encoded, Encoder, Layout, Sender};
use crate::transport::Transport;
use std::collections::VecDeque;
use wire::can::{CanFrame, DATA_BYTES_MAX};
use wire::device::Transmit;
use wire::time::Timestamp;

/// Messages of one sender on their way to its line: encoded, and in parts where they are longer than a frame.
#[derive(Debug, Clone)]
pub struct Outbox {
    /// Its counters go on from one message to the next.
    encoder: Encoder,
    queue: VecDeque<Waiting>,
    /// Messages that wait at the most.
    room: usize,
    /// Where messages go in parts.
    transport: Option<Box<Transport>>,
    dropped: u64,
}

/// What waits for the line.
#[derive(Debug, Clone)]
enum Waiting {
    /// A frame that its first bytes are all of: it is put together when the line takes it, which copies it once.
    Plain {
        message: usize,
        first: [u8; DATA_BYTES_MAX],
    },
    Whole(Transmit),
}

impl Outbox {
    /// That of whoever sends these messages of the layout, with room for so many that wait; what comes on top is dropped
    /// and counted.
    pub fn new(layout: Layout, sender: Sender, room: usize) -> Self {
        Self {
            transport: Transport::of(&layout, sender),
            encoder: Encoder::new(layout),
            queue: VecDeque::new(),
            room,
            dropped: 0,
        }
    }

    /// What it encodes.
    pub const fn layout(&self) -> &Layout {
        self.encoder.layout()
    }

    /// Sends a message with these values, one a signal and in its unit. Its counter and its checksum are what they have to
    /// be, but for those that `is_own` says yes to, by their places among the signals.
    ///
    /// # Errors
    /// As [`Layout::encode`]; the counter stays where it is.
    pub fn send(
        &mut self,
        now: Timestamp,
        message: usize,
        values: &[f64],
        is_own: impl Fn(usize) -> bool,
    ) -> Result<(), EncodeError> {
        if self.queue.len() < self.room
            && let Some(first) = self.encoder.first_bytes(message, values)
        {
            self.queue.push_back(Waiting::Plain { message, first });
            return Ok(());
        }
        match (self.encoder.encode(message, values, is_own), &mut self.transport) {
            (Ok(Encoded::Whole(what)), _) if self.queue.len() < self.room => {
                self.queue.push_back(Waiting::Whole(what));
            }
            (Ok(Encoded::InParts(parts)), Some(transport)) => transport.send(now, parts),
            (encoded, _) => {
                self.dropped += 1;
                encoded?;
            }
        }
        Ok(())
    }

    /// A frame was on its line: of use where messages go in parts, and somebody answers.
    pub fn receive(&mut self, now: Timestamp, frame: &CanFrame) {
        if let Some(transport) = &mut self.transport {
            transport.receive(now, frame);
        }
    }

    /// Does what is due of messages in parts.
    pub fn wake(&mut self, now: Timestamp) {
        if let Some(transport) = &mut self.transport {
            transport.wake(now);
        }
    }

    /// When to be woken, if nothing arrives before.
    pub fn next_wakeup(&self) -> Timestamp {
        self.transport.as_ref().map_or(Timestamp::MAX, |transport| transport.next_wakeup())
    }

    /// The next thing for the line.
    #[inline]
    pub fn transmit(&mut self) -> Option<Transmit> {
        let next = match self.queue.front() {
            Some(Waiting::Plain { message, first }) => {
                self.encoder.plain_frame(*message, *first).map(Transmit::Frame)
            }
            Some(Waiting::Whole(what)) => Some(*what),
            None => return self.transport.as_mut()?.transmit().map(Transmit::Frame),
        };
        self.queue.pop_front();
        next
    }

    /// Forgets what waits, and its counters begin again, as those of a device do that loses its power.
    pub fn reset(&mut self) {
        self.encoder.reset();
        self.queue.clear();
        if let Some(transport) = &mut self.transport {
            transport.reset();
        }
    }

    /// Messages that were not sent: a value was out of its range, too many waited, or in parts nobody answered.
    pub fn dropped(&self) -> u64 {
        self.dropped + self.transport.as_ref().map_or(0, |transport| transport.given_up())
    }
}
