//! Output queue of a node.

use crate::layout::{EncodeError, Encoded, Encoder, Layout, Message, Sender};
use crate::transport::Transport;
use std::collections::VecDeque;
use wire::can::CanFrame;
use wire::device::Transmit;
use wire::j1939;
use wire::time::Timestamp;

/// Queue of one sender's messages for its line: encoded, and split if they are longer than a frame.
#[derive(Debug, Clone)]
pub struct Outbox {
    /// Its counters advance from message to message.
    encoder: Encoder,
    /// Emptied when all have been taken. Not a deque: the compiler would build each item apart, and copy it.
    queue: Vec<Waiting>,
    /// How many of the queue the line has taken.
    taken: usize,
    /// Those of the queue that are whole, in its order.
    whole: VecDeque<Transmit>,
    /// Maximum number of waiting messages.
    room: usize,
    /// Present if messages are sent in parts.
    transport: Option<Box<Transport>>,
    dropped: u64,
}

#[derive(Debug, Clone)]
enum Waiting {
    /// A frame given by its first eight bytes: assembled when the line takes it, so that it is copied only once.
    Plain { message: usize, word: u64 },
    /// The next of the whole ones.
    Whole,
}

impl Outbox {
    /// The outbox of `sender` with room for `room` waiting messages; any more are dropped and counted.
    pub fn new(layout: Layout, sender: Sender, room: usize) -> Self {
        Self {
            transport: layout.addresses(sender).map(|own| Box::new(Transport::new(own))),
            encoder: Encoder::new(layout),
            queue: Vec::new(),
            taken: 0,
            whole: VecDeque::new(),
            room,
            dropped: 0,
        }
    }

    /// The layout that it encodes.
    pub const fn layout(&self) -> &Layout {
        self.encoder.layout()
    }

    /// Sends a message that is one frame without counter and checksum; false if it is another, a value is out of range,
    /// or there is no room.
    #[inline]
    pub(crate) fn send_plain(&mut self, message: usize, values: &[f64]) -> bool {
        if !self.has_room() {
            return false;
        }
        let Some(word) = self.encoder.plain_word(message, values) else { return false };
        self.queue.push(Waiting::Plain { message, word });
        true
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
        if self.send_plain(message, values) {
            return Ok(());
        }
        let has_room = self.has_room();
        match (self.encoder.encode(message, values, is_own), &mut self.transport) {
            (Ok(Encoded::Whole(what)), _) if has_room => {
                self.queue.push(Waiting::Whole);
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

    /// Whether a frame of this message is for its sender. A DBC cannot say "mine or all": where it has any destination, that in
    /// the frame decides.
    pub(crate) fn is_addressed(&self, message: &Message, frame: &CanFrame) -> bool {
        let is_for_any = message.group().is_some_and(|of| of.destination >= j1939::NULL);
        !is_for_any || self.transport.as_ref().is_none_or(|own| own.is_addressed(frame))
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
        let Some(next) = self.queue.get(self.taken) else {
            self.queue.clear();
            self.taken = 0;
            return self.transport.as_mut()?.transmit().map(Transmit::Frame);
        };
        self.taken += 1;
        match next {
            Waiting::Plain { message, word } => {
                self.encoder.plain_frame(*message, *word).map(Transmit::Frame)
            }
            Waiting::Whole => self.whole.pop_front(),
        }
    }

    /// True if one more message may wait.
    #[inline]
    fn has_room(&mut self) -> bool {
        // A line that never takes all of them must not make the queue longer.
        if self.taken >= self.room {
            self.queue.drain(..self.taken);
            self.taken = 0;
        }
        self.queue.len() - self.taken < self.room
    }

    /// Discards the queue and resets the counters, like a device that loses power.
    pub fn reset(&mut self) {
        self.encoder.reset();
        self.queue.clear();
        self.taken = 0;
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
