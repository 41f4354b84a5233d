//! The base's end: request lines in, answers out.

use super::super::payload::{decode_request, encode_reply};
use super::super::{Message, Reply, Request};
use super::{COMPUTER_ID, Line, LineDecoder, LineError, answer_checksum};
use crate::packet::Packet;

/// Meaning of a line from the host.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DeviceEvent {
    /// A write was received. `answer` acknowledges it: send [`write_answer`].
    Write {
        /// The request.
        request: Request,
        /// The line's checksum.
        answer: u8,
    },
    /// A read was received: send [`ReadAnswer::packet`].
    Read(ReadAnswer),
    /// A line that gets no answer.
    Refused(Refusal),
}

/// Reason for not answering a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refusal {
    /// Not a line, or one with more data than any register takes.
    Malformed,
    /// The sum of its bytes is not zero.
    BadChecksum,
    /// A good line for the computer with this id.
    OtherComputer(u8),
    /// No message at this address that can be written or, for a read, read.
    UnknownRegister(u16),
    /// The register of this message, but another byte count.
    WrongCount(Message),
    /// The register of this message, but a value that it refuses.
    WrongValue(Message),
}

/// Counters of a [`Device`] since its creation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DeviceCounters {
    /// Writes understood.
    pub writes: u64,
    /// Reads understood.
    pub reads: u64,
    /// [`Refusal::Malformed`].
    pub malformed: u64,
    /// [`Refusal::BadChecksum`].
    pub bad_checksum: u64,
    /// [`Refusal::OtherComputer`].
    pub other_computer: u64,
    /// [`Refusal::UnknownRegister`].
    pub unknown_register: u64,
    /// [`Refusal::WrongCount`].
    pub wrong_count: u64,
    /// [`Refusal::WrongValue`].
    pub wrong_value: u64,
    /// Characters outside of lines.
    pub skipped: u64,
}

/// Data needed to answer a read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReadAnswer {
    message: Message,
    request_checksum: u8,
}

impl ReadAnswer {
    /// The requested message: [`Message::Motion`] or [`Message::Pose`].
    pub const fn message(self) -> Message {
        self.message
    }

    /// The answer with this reply; `None` if it is not the requested message.
    pub fn packet(self, reply: &Reply) -> Option<Packet> {
        let (message, data) = encode_reply(reply);
        if message != self.message {
            return None;
        }
        let mut packet = Packet::from_slice(data.as_slice())?;
        packet.push(answer_checksum(self.request_checksum, data.as_slice()));
        Some(packet)
    }
}

/// The answer to a write: the byte given in [`DeviceEvent::Write`].
pub fn write_answer(answer: u8) -> Packet {
    let mut packet = Packet::new();
    packet.push(answer);
    packet
}

/// The base's end of the line. After any garbage it understands the next good line
/// ([`RESYNC_BYTES_MAX`](super::RESYNC_BYTES_MAX)).
#[derive(Debug, Clone, Default)]
pub struct Device {
    decoder: LineDecoder,
    counters: DeviceCounters,
}

impl Device {
    /// Takes bytes from the line, in runs of any length, and delivers one event per started line.
    pub fn feed(&mut self, bytes: &[u8], mut deliver: impl FnMut(DeviceEvent)) {
        for byte in bytes {
            let event = match self.decoder.push(*byte) {
                None => continue,
                Some(Ok(line)) => understand(&line).unwrap_or_else(DeviceEvent::Refused),
                Some(Err(LineError::Malformed)) => DeviceEvent::Refused(Refusal::Malformed),
                Some(Err(LineError::BadChecksum)) => DeviceEvent::Refused(Refusal::BadChecksum),
            };
            self.count(event);
            deliver(event);
        }
    }

    /// The counters.
    pub const fn counters(&self) -> DeviceCounters {
        DeviceCounters { skipped: self.decoder.skipped(), ..self.counters }
    }

    fn count(&mut self, event: DeviceEvent) {
        let counters = &mut self.counters;
        let counter = match event {
            DeviceEvent::Write { .. } => &mut counters.writes,
            DeviceEvent::Read(_) => &mut counters.reads,
            DeviceEvent::Refused(Refusal::Malformed) => &mut counters.malformed,
            DeviceEvent::Refused(Refusal::BadChecksum) => &mut counters.bad_checksum,
            DeviceEvent::Refused(Refusal::OtherComputer(_)) => &mut counters.other_computer,
            DeviceEvent::Refused(Refusal::UnknownRegister(_)) => &mut counters.unknown_register,
            DeviceEvent::Refused(Refusal::WrongCount(_)) => &mut counters.wrong_count,
            DeviceEvent::Refused(Refusal::WrongValue(_)) => &mut counters.wrong_value,
        };
        *counter += 1;
    }
}

/// Decodes a good line with this command set.
fn understand(line: &Line) -> Result<DeviceEvent, Refusal> {
    let (address, computer, count, is_read) = match line {
        Line::Write { address, computer, data } => {
            (*address, *computer, data.as_slice().len(), false)
        }
        Line::Read { address, computer, count } => (*address, *computer, usize::from(*count), true),
    };
    if computer != COMPUTER_ID {
        return Err(Refusal::OtherComputer(computer));
    }
    let message = Message::from_register(address)
        .filter(|message| message.is_reply() == is_read)
        .ok_or(Refusal::UnknownRegister(address))?;
    if count != message.payload_bytes() {
        return Err(Refusal::WrongCount(message));
    }
    match line {
        Line::Write { data, .. } => decode_request(message, data.as_slice())
            .map(|request| DeviceEvent::Write { request, answer: line.checksum() })
            .ok_or(Refusal::WrongValue(message)),
        Line::Read { .. } => {
            Ok(DeviceEvent::Read(ReadAnswer { message, request_checksum: line.checksum() }))
        }
    }
}
