//! Decodes frames and bytes to values. On a serial line it finds the next good message after damage.
//!
//! Answers that look the same are told apart by the [requests](Decoder::overhear) on the other way of the line.

use super::message::{Carrier, Found, Message, judge};
use super::{Decoded, Layout, Sender};
use crate::protection::Received;
use crate::transport::{Heard, Reassembly};
use std::collections::BTreeMap;
use wire::can::{CanFrame, Id};
use wire::j1939::{self, Identifier};
use wire::packet::BYTES_MAX;
use wire::time::Timestamp;

/// Finds messages in received data.
///
/// On a serial line it keeps at most [`BYTES_MAX`] bytes: after damage, the next good message is found at most that
/// many bytes after its end.
#[derive(Debug, Clone)]
pub struct Decoder {
    layout: Layout,
    sender: Option<Sender>,
    /// At most [`BYTES_MAX`] bytes that may become a message.
    buffer: Vec<u8>,
    /// Values of the last message, one per signal.
    values: Vec<Option<f64>>,
    /// One per message.
    received: Vec<Received>,
    /// Messages being received in parts, if the layout has parameter groups of J1939.
    reassembly: Option<Box<Reassembly>>,
    /// See [`Decoder::foreign`].
    foreign: Option<Id>,
    /// The next byte is not in the middle of a line of text.
    line_begins: bool,
    /// Decodes the requests that tell answers apart, if there are such.
    requests: Option<Box<Decoder>>,
    /// The last of these requests, until it is answered.
    asked: Option<usize>,
    damaged: u64,
    /// How many frames of each message had fewer or more bytes than it has.
    short: BTreeMap<usize, u64>,
    long: BTreeMap<usize, u64>,
    /// See [`Decoder::alone`].
    alone: BTreeMap<usize, u64>,
    checksum_failures: u64,
    /// Messages of a serial line with a wrong checksum in the place of a message, and how many.
    spoilt: BTreeMap<usize, u64>,
    /// Bytes until the next message of a serial line should begin; `None` after damage, as long as none was found.
    until_next: Option<usize>,
}

impl Decoder {
    pub(super) fn new(layout: Layout, sender: Option<Sender>) -> Self {
        Self {
            buffer: Vec::with_capacity(BYTES_MAX),
            values: Vec::new(),
            received: vec![Received::default(); layout.messages.len()],
            reassembly: layout.messages.iter().any(|one| one.group.is_some()).then(Box::default),
            foreign: None,
            line_begins: true,
            requests: requests(&layout, sender),
            asked: None,
            damaged: 0,
            short: BTreeMap::new(),
            long: BTreeMap::new(),
            alone: BTreeMap::new(),
            checksum_failures: 0,
            spoilt: BTreeMap::new(),
            until_next: Some(0),
            layout,
            sender,
        }
    }

    /// The layout that it decodes.
    pub const fn layout(&self) -> &Layout {
        &self.layout
    }

    /// The sender whose messages it decodes; `None` for all.
    pub const fn sender(&self) -> Option<Sender> {
        self.sender
    }

    /// True if a frame with this identifier is a message to decode, or a part of one.
    pub fn takes(&self, id: Id) -> bool {
        match self.layout.identifiers.find(id) {
            Some(index) => hears(self.sender, &self.layout.messages[index]),
            None => {
                self.reassembly.is_some() && (self.is_of_transport(id) || self.group(id).is_some())
            }
        }
    }

    /// True if a decoded sender sends frames of J1939's transport protocol with this identifier.
    fn is_of_transport(&self, id: Id) -> bool {
        let Id::Extended(id) = id else { return false };
        let from = Identifier::from(id);
        let mut groups = self.layout.messages.iter().filter(|one| hears(self.sender, one));
        j1939::is_transport(from)
            && groups.any(|one| {
                one.group.is_some_and(|of| [from.source, j1939::NULL].contains(&of.source))
            })
    }

    /// The message of this parameter group, of whatever length.
    fn group(&self, id: Id) -> Option<usize> {
        let Id::Extended(id) = id else { return None };
        let heard = Identifier::from(id);
        self.layout.messages.iter().position(|message| {
            hears(self.sender, message) && message.group.is_some_and(|group| group.means(heard))
        })
    }

    /// It is `now`, before the next frame: a message in parts that takes too long between two of them is damage.
    #[inline]
    pub fn at(&mut self, now: Timestamp) -> &mut Self {
        if let Some(reassembly) = &mut self.reassembly {
            self.damaged += reassembly.late(now);
        }
        self
    }

    /// The node that listens sends this frame itself: a message in parts that it aborts, it does not take any more.
    #[inline]
    pub(crate) fn says(&mut self, frame: &CanFrame) {
        if let Some(reassembly) = &mut self.reassembly {
            reassembly.aborted(frame);
        }
    }

    /// The identifier that a single frame of its group would have had, if the last frame completed a message in parts that is not
    /// in the layout.
    pub const fn foreign(&mut self) -> Option<Id> {
        self.foreign.take()
    }

    /// The message in a CAN frame, or the one that it completes; `None` if no message has its identifier, for a remote
    /// request, and if the frame has fewer bytes than the message.
    #[inline]
    pub fn frame(&mut self, frame: &CanFrame) -> Option<Decoded<'_>> {
        let Some(index) = self.layout.identifiers.find(frame.id()) else {
            return self.part(frame);
        };
        let message = &self.layout.messages[index];
        let Carrier::Frame { length, fd, .. } = message.carrier else { return None };
        if frame.is_remote() || !hears(self.sender, message) {
            return None;
        }
        if frame.data().len() < length {
            self.damaged += 1;
            *self.short.entry(index).or_default() += 1;
            return None;
        }
        // A frame of CAN FD is filled up to the next length that there is, and one of diagnostics has any length.
        if frame.data().len() > length && fd.is_none() && !message.signals.is_empty() {
            *self.long.entry(index).or_default() += 1;
        }
        self.layout.frames[index].read(message, frame.data(), &mut self.values);
        let verdict = judge(message, frame.data(), &mut self.received[index], &mut self.values);
        Some(Decoded { message: index, form: message, values: &self.values, verdict })
    }

    /// The message that a frame of the transport protocol completes, or one in parts that fits into a frame.
    #[cold]
    fn part(&mut self, frame: &CanFrame) -> Option<Decoded<'_>> {
        let id = frame.id();
        let Id::Extended(extended) = id else { return None };
        if self.reassembly.is_none() || frame.is_remote() {
            return None;
        }
        if !j1939::is_transport(extended.into()) {
            let index = self.group(id)?;
            if self.layout.messages[index].is_in_parts() {
                *self.alone.entry(index).or_default() += 1;
            }
            return self.variable(index, frame.data());
        }
        match self.reassembly.as_mut()?.frame(frame) {
            Heard::Nothing => None,
            Heard::Stray => {
                self.damaged += 1;
                None
            }
            Heard::Whole(about, data) => {
                let about = Id::Extended(about.id());
                let Some(index) = self.group(about) else {
                    self.foreign = Some(about);
                    return None;
                };
                self.variable(index, &data)
            }
        }
    }

    /// A parameter group with these bytes: its length varies, and a signal that lies beyond them is not carried.
    fn variable(&mut self, index: usize, data: &[u8]) -> Option<Decoded<'_>> {
        let message = &self.layout.messages[index];
        message.read(data, &mut self.values);
        for (signal, value) in message.signals.iter().zip(&mut self.values) {
            *value = value.filter(|_| signal.is_within(data.len()));
        }
        // What a checksum covers is all there.
        if message.protected.is_some() && data.len() < message.payload().end {
            self.damaged += 1;
            return None;
        }
        let verdict = judge(message, data, &mut self.received[index], &mut self.values);
        Some(Decoded { message: index, form: message, values: &self.values, verdict })
    }

    /// Passes each message that these bytes complete to `each`.
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

    /// Takes the bytes that came from the other end of the serial line: answers that look the same are told apart by the
    /// last request.
    pub fn overhear(&mut self, bytes: &[u8]) {
        let Self { requests: Some(requests), layout, asked, .. } = self else { return };
        let tells = |request: usize| {
            let mut told_by = layout.messages.iter().filter_map(|message| message.told_by);
            told_by.any(|told_by| told_by.request == request)
        };
        requests.bytes(bytes, &mut |request| {
            if request.is_sound() && tells(request.message) {
                *asked = Some(request.message);
            }
        });
    }

    /// Discards partial messages, like a device that loses power.
    pub fn reset(&mut self) {
        self.buffer.clear();
        if let Some(reassembly) = &mut self.reassembly {
            reassembly.reset();
        }
        self.line_begins = true;
        self.until_next = Some(0);
        self.asked = None;
        if let Some(requests) = &mut self.requests {
            requests.reset();
        }
        self.received.fill(Received::default());
    }

    /// Bytes of a serial line outside of messages, and CAN frames that are too short for their message.
    pub const fn damaged(&self) -> u64 {
        self.damaged
    }

    /// How many of the [damaged](Self::damaged) are CAN frames of a message with fewer bytes than it has.
    pub fn short(&self) -> impl Iterator<Item = (&Message, u64)> {
        self.each(&self.short)
    }

    /// How many CAN frames of a message had more bytes than it has. They count as the message.
    pub fn long(&self) -> impl Iterator<Item = (&Message, u64)> {
        self.each(&self.long)
    }

    /// How many single frames came of a parameter group that is longer: they count as the message, as far as they go. It may be
    /// short this time, or this is a part of an NMEA 2000 fast packet.
    pub fn alone(&self) -> impl Iterator<Item = (&Message, u64)> {
        self.each(&self.alone)
    }

    fn each<'s>(
        &'s self,
        counts: &'s BTreeMap<usize, u64>,
    ) -> impl Iterator<Item = (&'s Message, u64)> {
        counts.iter().map(|(message, count)| (&self.layout.messages[*message], *count))
    }

    /// The messages of a serial line that came with a wrong checksum, where one was expected, and how many: their bytes are
    /// not among the [damaged](Self::damaged).
    pub fn spoilt(&self) -> impl Iterator<Item = (&Message, u64)> {
        self.each(&self.spoilt)
    }

    /// Number of messages on a serial line with a wrong checksum.
    pub const fn checksum_failures(&self) -> u64 {
        self.checksum_failures
    }

    /// Takes complete content from the buffer, and leaves room for at least one byte.
    fn search(&mut self, each: &mut dyn FnMut(Decoded<'_>)) {
        let mut at = 0;
        while at < self.buffer.len() {
            let (message, found) = self.first(at);
            match found {
                Found::Whole(length) => {
                    let packet = &self.buffer[at..at + length];
                    let known = &self.layout.messages[message];
                    let verdict =
                        judge(known, packet, &mut self.received[message], &mut self.values);
                    at += length;
                    self.line_begins = true;
                    self.until_next = Some(0);
                    if known.told_by.is_some_and(|told_by| !told_by.repeats) {
                        self.asked = None;
                    }
                    each(Decoded { message, form: known, values: &self.values, verdict });
                }
                Found::Beginning if self.buffer.len() - at < BYTES_MAX => break,
                found => {
                    if let Found::WrongChecksum(length) = found {
                        self.checksum_failures += 1;
                        self.spoil(message, length, at);
                    }
                    self.line_begins = matches!(self.buffer[at], b'\r' | b'\n');
                    // A part of a damaged message may be a good one: the search goes on at its next byte.
                    self.until_next = match self.until_next {
                        Some(0) | None => None,
                        Some(bytes) => Some(bytes - 1),
                    };
                    self.damaged += u64::from(self.until_next.is_none());
                    at += 1;
                }
            }
        }
        self.buffer.drain(..at);
    }

    /// Counts a `message` of `length` bytes with a wrong checksum, if one should begin `at` this place: elsewhere its first
    /// bytes may be any. Its counter goes on as it should.
    fn spoil(&mut self, message: usize, length: usize, at: usize) {
        let mut others = (0..self.layout.messages.len()).filter(|other| *other != message);
        let is_another = |other: usize| {
            let found = self.layout.messages[other].find(&self.buffer[at..], &mut Vec::new());
            matches!(found, Found::WrongChecksum(_))
        };
        let is_line = matches!(self.layout.messages[message].carrier, Carrier::Line(_));
        if (is_line || self.until_next == Some(0)) && !others.any(is_another) {
            self.until_next = Some(length);
            self.received[message].damage();
            *self.spoilt.entry(message).or_default() += 1;
        }
    }

    /// The first message of the file that matches the bytes from `at` on, or otherwise that they may become, with its
    /// index.
    fn first(&mut self, at: usize) -> (usize, Found) {
        let mut best = (0, Found::Nothing);
        for (index, message) in self.layout.messages.iter().enumerate() {
            let inside_a_line = match &message.carrier {
                Carrier::Line(pattern) => !self.line_begins && !pattern.has_start(),
                _ => false,
            };
            let is_of_another = message.told_by.is_some_and(|by| Some(by.request) != self.asked);
            if inside_a_line || is_of_another || !hears(self.sender, message) {
                continue;
            }
            match (message.find(&self.buffer[at..], &mut self.values), &best.1) {
                (whole @ Found::Whole(_), _) => return (index, whole),
                (Found::Beginning, _) => best = (index, Found::Beginning),
                (spoilt @ Found::WrongChecksum(_), Found::Nothing) => best = (index, spoilt),
                _ => {}
            }
        }
        best
    }
}

/// The decoder of the other side's requests, if they tell messages of `sender` apart.
fn requests(layout: &Layout, sender: Option<Sender>) -> Option<Box<Decoder>> {
    let mut sent = layout.messages.iter().filter(|message| Some(message.sender) == sender);
    let other = match sender? {
        Sender::Device => Sender::Host,
        Sender::Host => Sender::Device,
    };
    let is_needed = sent.any(|message| message.told_by.is_some());
    is_needed.then(|| Box::new(Decoder::new(layout.clone(), Some(other))))
}

fn hears(sender: Option<Sender>, message: &Message) -> bool {
    sender.is_none_or(|sender| message.sender == sender)
}
