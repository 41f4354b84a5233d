//! Frames and bytes back to values. On a serial line it finds the next good message behind damage.

use super::message::{Carrier, Found, Message};
use super::{Decoded, Layout, Sender};
use crate::protection::{Received, Verdict};
use crate::transport::{Heard, Reassembly};
use wire::can::{CanFrame, Id};
use wire::j1939::{self, Identifier};
use wire::packet::BYTES_MAX;

/// Finds messages in what is received.
///
/// On a serial line nothing is kept of more than [`BYTES_MAX`] bytes: behind damage the next good message
/// is found at the latest that many bytes after it is whole.
#[derive(Debug, Clone)]
pub struct Decoder {
    layout: Layout,
    sender: Option<Sender>,
    /// At most [`BYTES_MAX`] bytes that may become a message.
    buffer: Vec<u8>,
    /// Of the last message, one a signal.
    values: Vec<Option<f64>>,
    /// One a message.
    received: Vec<Received>,
    /// What is under way in parts, where there are messages that go so.
    reassembly: Option<Box<Reassembly>>,
    /// What comes next is not the middle of a line of text.
    line_begins: bool,
    damaged: u64,
    checksum_failures: u64,
}

impl Decoder {
    pub(super) fn new(layout: Layout, sender: Option<Sender>) -> Self {
        Self {
            buffer: Vec::with_capacity(BYTES_MAX),
            values: Vec::new(),
            received: vec![Received::default(); layout.messages.len()],
            reassembly: layout.messages.iter().any(Message::is_in_parts).then(Box::default),
            line_begins: true,
            damaged: 0,
            checksum_failures: 0,
            layout,
            sender,
        }
    }

    /// What it reads.
    pub const fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Whose messages it hears; those of all where there is none.
    pub const fn sender(&self) -> Option<Sender> {
        self.sender
    }

    /// A frame of this identifier is a message that is heard, or a part of one.
    pub fn takes(&self, id: Id) -> bool {
        match self.layout.identifiers.find(id) {
            Some(index) => hears(self.sender, &self.layout.messages[index]),
            None => self.reassembly.is_some() && self.is_of_transport(id),
        }
    }

    /// Somebody who is heard sends frames of J1939's transport protocol with this identifier.
    fn is_of_transport(&self, id: Id) -> bool {
        let Id::Extended(id) = id else { return false };
        let from = Identifier::from(id);
        let mut groups = self.layout.messages.iter().filter(|one| hears(self.sender, one));
        j1939::is_transport(from)
            && groups.any(|one| one.group.is_some_and(|of| of.source == from.source))
    }

    /// The message in a CAN frame, or that it completes; `None` where no message has its identifier, for a remote request,
    /// and where the frame has fewer bytes than the message.
    #[inline]
    pub fn frame(&mut self, frame: &CanFrame) -> Option<Decoded<'_>> {
        let Some(index) = self.layout.identifiers.find(frame.id()) else {
            return self.part(frame);
        };
        let message = &self.layout.messages[index];
        let Carrier::Frame { length, .. } = message.carrier else { return None };
        if frame.is_remote() || !hears(self.sender, message) {
            return None;
        }
        if frame.data().len() < length {
            self.damaged += 1;
            return None;
        }
        self.layout.frames[index].read(message, frame.data(), &mut self.values);
        let verdict = judge(message, frame.data(), &mut self.received[index]);
        Some(Decoded { message: index, form: message, values: &self.values, verdict })
    }

    /// The message in parts that a frame completes.
    #[cold]
    fn part(&mut self, frame: &CanFrame) -> Option<Decoded<'_>> {
        let (messages, sender) = (&self.layout.messages, self.sender);
        let find = |heard: Identifier| {
            messages.iter().position(|message| {
                message.is_in_parts()
                    && hears(sender, message)
                    && message.group.is_some_and(|group| group.means(heard))
            })
        };
        let heard = self.reassembly.as_mut()?.frame(frame, |heard| find(heard).is_some());
        let (about, data) = match heard {
            Heard::Whole(about, data) => (about, data),
            heard => {
                self.damaged += u64::from(matches!(heard, Heard::Stray));
                return None;
            }
        };
        let index = find(about)?;
        let message = &messages[index];
        let Carrier::Parts { length, .. } = message.carrier else { return None };
        if data.len() < length {
            self.damaged += 1;
            return None;
        }
        message.read(&data, &mut self.values);
        let verdict = judge(message, &data, &mut self.received[index]);
        Some(Decoded { message: index, form: message, values: &self.values, verdict })
    }

    /// Hands each message over that these bytes complete.
    pub fn bytes(&mut self, bytes: &[u8], each: &mut dyn FnMut(Decoded<'_>)) {
        let mut rest = bytes;
        loop {
            let room = BYTES_MAX - self.buffer.len();
            let (now, later) = rest.split_at(room.min(rest.len()));
            self.buffer.extend_from_slice(now);
            rest = later;
            self.search(each);
            if rest.is_empty() {
                return;
            }
        }
    }

    /// Forgets what was begun, as a device does that loses its power.
    pub fn reset(&mut self) {
        self.buffer.clear();
        if let Some(reassembly) = &mut self.reassembly {
            reassembly.reset();
        }
        self.line_begins = true;
        self.received.fill(Received::default());
    }

    /// Bytes of a serial line that belong to no message, and CAN frames that are too short for theirs.
    pub const fn damaged(&self) -> u64 {
        self.damaged
    }

    /// Messages of a serial line whose checksum was another.
    pub const fn checksum_failures(&self) -> u64 {
        self.checksum_failures
    }

    /// Takes from the buffer what is certain, and leaves room in it for at least one byte.
    fn search(&mut self, each: &mut dyn FnMut(Decoded<'_>)) {
        let mut at = 0;
        while at < self.buffer.len() {
            let (message, found) = self.first(at);
            match found {
                Found::Whole(length) => {
                    let packet = &self.buffer[at..at + length];
                    let known = &self.layout.messages[message];
                    let verdict = judge(known, packet, &mut self.received[message]);
                    at += length;
                    self.line_begins = true;
                    each(Decoded { message, form: known, values: &self.values, verdict });
                }
                Found::Beginning if self.buffer.len() - at < BYTES_MAX => break,
                found => {
                    self.checksum_failures += u64::from(matches!(found, Found::WrongChecksum));
                    self.line_begins = matches!(self.buffer[at], b'\r' | b'\n');
                    self.damaged += 1;
                    at += 1;
                }
            }
        }
        self.buffer.drain(..at);
    }

    /// The first message of the file that the bytes behind `at` are, or else that they may become, and its place.
    fn first(&mut self, at: usize) -> (usize, Found) {
        let mut best = (0, Found::Nothing);
        for (index, message) in self.layout.messages.iter().enumerate() {
            let inside_a_line = matches!(message.carrier, Carrier::Line(_)) && !self.line_begins;
            if inside_a_line || !hears(self.sender, message) {
                continue;
            }
            match (message.find(&self.buffer[at..], &mut self.values), &best.1) {
                (whole @ Found::Whole(_), _) => return (index, whole),
                (Found::Beginning, _) => best = (index, Found::Beginning),
                (Found::WrongChecksum, Found::Nothing) => best = (index, Found::WrongChecksum),
                _ => {}
            }
        }
        best
    }
}

fn hears(sender: Option<Sender>, message: &Message) -> bool {
    sender.is_none_or(|sender| message.sender == sender)
}

/// What counter and checksum among the signals say of a message with these bytes.
#[inline]
fn judge(message: &Message, data: &[u8], received: &mut Received) -> Option<Verdict> {
    let protected = message.protected.as_ref()?;
    Some(protected.protection.check(data.get(message.payload())?, received))
}
