//! The host's end: request lines out, answers in, one exchange at a time.

use super::super::payload::{decode_reply, encode_request};
use super::super::{Message, Reply, Request};
use super::{ANSWER_BYTES_MAX, COMPUTER_ID, Line, answer_checksum};
use crate::packet::Packet;

/// Meaning of the bytes from the base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum HostEvent {
    /// The base received this write.
    Written(Message),
    /// The answer to a read.
    Reply(Reply),
    /// The answer to this exchange was corrupted, which ends the exchange. Wait [`quiet_time`](super::quiet_time)
    /// before the next.
    BadChecksum(Message),
    /// An unexpected byte.
    Unexpected(u8),
}

/// Counters of a [`Host`] since its creation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct HostCounters {
    /// Exchanges started.
    pub started: u64,
    /// Writes acknowledged.
    pub written: u64,
    /// Reads answered.
    pub replies: u64,
    /// Exchanges that ended in a corrupted answer.
    pub bad_checksum: u64,
    /// Exchanges abandoned by the caller.
    pub abandoned: u64,
    /// Unexpected bytes.
    pub unexpected: u64,
}

#[derive(Debug, Clone, Copy)]
struct Exchange {
    message: Message,
    request_checksum: u8,
    answer: [u8; ANSWER_BYTES_MAX],
    received: usize,
}

/// The host's end of the line. It has no clock: the caller limits the wait for an answer and calls [`Host::abandon`].
#[derive(Debug, Clone, Default)]
pub struct Host {
    outstanding: Option<Exchange>,
    counters: HostCounters,
}

impl Host {
    /// Starts an exchange: returns the line to send. Returns `None` and starts nothing while another exchange is
    /// outstanding, or for a value that [`payload`](crate::base::payload) refuses.
    pub fn start(&mut self, request: &Request) -> Option<Packet> {
        if self.busy() {
            return None;
        }
        let read = |message: Message| {
            let count = message.payload_bytes() as u8;
            (message, Line::Read { address: message.register(), computer: COMPUTER_ID, count })
        };
        let (message, line) = match request {
            Request::ReadMotion => read(Message::Motion),
            Request::ReadPose => read(Message::Pose),
            write => {
                let (message, data) = encode_request(write)?;
                let address = message.register();
                (message, Line::Write { address, computer: COMPUTER_ID, data })
            }
        };
        self.outstanding = Some(Exchange {
            message,
            request_checksum: line.checksum(),
            answer: [0; ANSWER_BYTES_MAX],
            received: 0,
        });
        self.counters.started += 1;
        Some(line.encode())
    }

    /// Takes bytes from the line, in runs of any length, and delivers their meaning.
    pub fn feed(&mut self, bytes: &[u8], mut deliver: impl FnMut(HostEvent)) {
        for byte in bytes {
            if let Some(event) = self.push(*byte) {
                self.count(event);
                deliver(event);
            }
        }
    }

    /// True if an answer is outstanding.
    pub const fn busy(&self) -> bool {
        self.outstanding.is_some()
    }

    /// Abandons the outstanding exchange and returns its message. Wait [`quiet_time`](super::quiet_time) before the
    /// next.
    pub fn abandon(&mut self) -> Option<Message> {
        let exchange = self.outstanding.take()?;
        self.counters.abandoned += 1;
        Some(exchange.message)
    }

    /// The counters.
    pub const fn counters(&self) -> HostCounters {
        self.counters
    }

    fn push(&mut self, byte: u8) -> Option<HostEvent> {
        let Some(exchange) = self.outstanding.as_mut() else {
            return Some(HostEvent::Unexpected(byte));
        };
        let message = exchange.message;
        let data_bytes = if message.is_reply() { message.payload_bytes() } else { 0 };
        if exchange.received < data_bytes {
            exchange.answer[exchange.received] = byte;
            exchange.received += 1;
            return None;
        }
        let data = &exchange.answer[..data_bytes];
        let good = byte == answer_checksum(exchange.request_checksum, data);
        let event = match decode_reply(message, data) {
            _ if !good => HostEvent::BadChecksum(message),
            Some(reply) => HostEvent::Reply(reply),
            None => HostEvent::Written(message),
        };
        self.outstanding = None;
        Some(event)
    }

    fn count(&mut self, event: HostEvent) {
        let counter = match event {
            HostEvent::Written(_) => &mut self.counters.written,
            HostEvent::Reply(_) => &mut self.counters.replies,
            HostEvent::BadChecksum(_) => &mut self.counters.bad_checksum,
            HostEvent::Unexpected(_) => &mut self.counters.unexpected,
        };
        *counter += 1;
    }
}
