//! Output queue of a node.

use crate::layout::{EncodeError, Encoded, Encoder, Layout, Sender};
use crate::transport::Transport;
use std::collections::VecDeque;
use wire::can::{CanFrame, DATA_BYTES_MAX};
use wire::device::Transmit;
use wire::time::Timestamp;

/// Queue of one sender's messages for its line: encoded, and split if they are longer than a frame.
#[derive(Debug, Clone)]
pub struct Outbox {
    /// Its counters advance from message to message.
    encoder: Encoder,
    queue: VecDeque<Waiting>,
    /// Those of the queue that are whole, in its order.
    whole: VecDeque<Transmit>,
    /// Maximum number of waiting messages.
    room: usize,
    /// Present if messages are sent in parts.
    transport: Option<Box<Transport>>,
    dropped: u64,
}

/// An item waiting for the line.
#[derive(Debug, Clone)]
enum Waiting {
    /// A frame given by its first bytes: assembled when the line takes it, so that it is copied only once.
    Plain { message: usize, first: [u8; DATA_BYTES_MAX] },
    /// The next of the whole ones.
    Whole,
}

impl Outbox {
    /// The outbox of `sender` with room for `room` waiting messages; any more are dropped and counted.
    pub fn new(layout: Layout, sender: Sender, room: usize) -> Self {
        Self {
            transport: Transport::of(&layout, sender),
            encoder: Encoder::new(layout),
            queue: VecDeque::new(),
            whole: VecDeque::new(),
            room,
            dropped: 0,
        }
    }

    /// The layout that it encodes.
    pub const fn layout(&self) -> &Layout {
        self.encoder.layout()
    }

    /// Sends a message with these values, one per signal and in its unit. Counter and checksum are computed, except
    /// for signals that `is_own` accepts by position.
    ///
    /// # Errors
    /// As [`Layout::encode`]; the counter then stays unchanged.
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
                self.queue.push_back(Waiting::Whole);
                self.whole.push_back(what);
            }
            (Ok(Encoded::InParts(parts)), Some(transport)) => transport.send(now, parts),
            (encoded, _) => {
                self.dropped += 1;
                encoded?;
            }
        }
        Ok(())
    }

    /// Takes a frame from its line: needed for messages in parts that a receiver answers.
    pub fn receive(&mut self, now: Timestamp, frame: &CanFrame) {
        if let Some(transport) = &mut self.transport {
            transport.receive(now, frame);
        }
    }

    /// Does the work due for messages in parts.
    pub fn wake(&mut self, now: Timestamp) {
        if let Some(transport) = &mut self.transport {
            transport.wake(now);
        }
    }

    /// Time of the next wake-up if nothing arrives before.
    pub fn next_wakeup(&self) -> Timestamp {
        self.transport.as_ref().map_or(Timestamp::MAX, |transport| transport.next_wakeup())
    }

    /// The next output for the line.
    #[inline]
    pub fn transmit(&mut self) -> Option<Transmit> {
        match self.queue.pop_front() {
            Some(Waiting::Plain { message, first }) => {
                self.encoder.plain_frame(message, first).map(Transmit::Frame)
            }
            Some(Waiting::Whole) => self.whole.pop_front(),
            None => self.transport.as_mut()?.transmit().map(Transmit::Frame),
        }
    }

    /// Discards the queue and resets the counters, like a device that loses power.
    pub fn reset(&mut self) {
        self.encoder.reset();
        self.queue.clear();
        self.whole.clear();
        if let Some(transport) = &mut self.transport {
            transport.reset();
        }
    }

    /// Number of messages not sent: a value was out of range, the queue was full, or no receiver answered a message in
    /// parts.
    pub fn dropped(&self) -> u64 {
        self.dropped + self.transport.as_ref().map_or(0, |transport| transport.given_up())
    }
}
