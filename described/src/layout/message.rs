//! One message: its signals and its carrier.

use super::EncodeError;
use super::Sender;
use super::checksum::Trailer;
use super::multiplexing;
use super::printed::Match;
use super::selection::Selection;
use super::send_rule::SendRule;
use super::signal::Signal;
use super::text::Pattern;
use crate::protection::{Own, Protection, Received, Sent, Verdict};
use crate::transport::InParts;
use std::collections::BTreeSet;
use std::ops::Range;
use wire::can::{CanFrame, ExtendedId, FD_BYTES_MAX, FdFlags, Id};
use wire::device::Transmit;
use wire::j1939::{Identifier, PACKET_BYTES};
use wire::packet::{BYTES_MAX, Packet};
use wire::time::Span;

/// Signals that are sent together.
#[derive(Debug, Clone, PartialEq)]
pub struct Message {
    /// Its name, unique in the layout.
    pub name: String,
    /// The sender.
    pub sender: Sender,
    /// The period, if it is periodic.
    pub period: Option<Span>,
    /// Other conditions for sending it.
    pub send: SendRule,
    /// Its signals, in the order of the file.
    pub signals: Vec<Signal>,
    /// Documentation from the file.
    pub doc: String,
    pub(super) carrier: Carrier,
    /// The identifier's fields, if it is a parameter group of J1939.
    pub(super) group: Option<Identifier>,
    /// Its counter and its checksum among the signals, if any.
    pub(crate) protected: Option<Protected>,
    /// What tells it from other messages that look the same, if there are any.
    pub(super) told_by: Option<ToldBy>,
}

/// The request that an answer follows, which tells it from answers to other requests.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ToldBy {
    /// Index of the request.
    pub(super) request: usize,
    /// The answer can be several messages.
    pub(super) repeats: bool,
}

/// The protection of a message, and the signals that hold it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Protected {
    pub(super) protection: Protection,
    /// The position of the counter among the signals.
    pub(crate) counter: Option<usize>,
    /// The position of the checksum.
    pub(crate) checksum: Option<usize>,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Carrier {
    /// A CAN frame of this length; CAN FD if it has flags.
    Frame {
        id: Id,
        length: usize,
        fd: Option<FdFlags>,
    },
    /// This many bytes in the packets of J1939's transport protocol: more than a frame holds.
    Parts {
        id: ExtendedId,
        length: usize,
    },
    /// Bytes with a fixed start, and a checksum at the end.
    Packet {
        start: Vec<u8>,
        length: usize,
        trailer: Option<Trailer>,
    },
    Line(Pattern),
}

impl Message {
    /// A message of this carrier, which nothing sends by itself, without documentation and protection.
    pub(super) fn new(
        name: String,
        sender: Sender,
        carrier: Carrier,
        signals: Vec<Signal>,
    ) -> Self {
        Self {
            name,
            sender,
            period: None,
            send: SendRule::default(),
            signals,
            doc: String::new(),
            carrier,
            group: None,
            protected: None,
            told_by: None,
        }
    }

    /// The numbers of a multiplexer that select signals, in ascending order: the ends of ranges.
    pub fn pages(&self, multiplexer: usize) -> BTreeSet<u64> {
        let selections = self.signals.iter().filter_map(|signal| signal.carried.selection());
        let of_it = selections.filter(|selection| selection.multiplexer == multiplexer);
        let ends = of_it.flat_map(|selection| &selection.numbers);
        let ends = ends.flat_map(|range| [*range.start(), *range.end()]);
        ends.filter(|number| self.signals[multiplexer].reaches(*number)).collect()
    }

    /// The selections required for a signal to be carried: of its multiplexer, of that one's own, and so on.
    pub fn selections(&self, signal: usize) -> impl Iterator<Item = &Selection> {
        multiplexing::needs(&self.signals, signal)
    }

    /// Its identifier on CAN; for a message [in parts](Self::is_in_parts), the one that its frame would have.
    pub const fn can_id(&self) -> Option<Id> {
        match self.carrier {
            Carrier::Frame { id, .. } => Some(id),
            Carrier::Parts { id, .. } => Some(Id::Extended(id)),
            Carrier::Packet { .. } | Carrier::Line(_) => None,
        }
    }

    /// The identifier's fields, if it is a parameter group of J1939.
    pub const fn group(&self) -> Option<Identifier> {
        self.group
    }

    /// True if it is longer than a frame: J1939's transport protocol carries it.
    pub const fn is_in_parts(&self) -> bool {
        matches!(self.carrier, Carrier::Parts { .. })
    }

    /// True if another message looks the same, and the request that it answers tells them apart.
    pub const fn is_told_by_request(&self) -> bool {
        self.told_by.is_some()
    }

    /// Number of frames that carry it, including the announcement of a message in parts.
    pub fn frames(&self) -> i64 {
        match self.carrier {
            Carrier::Parts { length, .. } => 1 + length.div_ceil(PACKET_BYTES) as i64,
            _ => 1,
        }
    }

    /// True for a CAN FD frame.
    pub const fn is_fd(&self) -> bool {
        matches!(self.carrier, Carrier::Frame { fd: Some(_), .. })
    }

    /// Whether a signal is the counter or the checksum of the message, which a sender computes.
    pub fn is_computed(&self, signal: usize) -> bool {
        let protected = self.protected.as_ref();
        protected.is_some_and(|one| [one.counter, one.checksum].contains(&Some(signal)))
    }

    /// The positions of its multiplexers among its signals.
    pub fn multiplexers(&self) -> impl Iterator<Item = usize> {
        let signals = self.signals.iter().enumerate();
        signals.filter(|(_, signal)| signal.multiplexes).map(|(place, _)| place)
    }

    /// True if the frame with these values, one per signal and in its unit, carries the signal at this position.
    pub fn carries(&self, signal: usize, values: &[f64]) -> bool {
        multiplexing::carries(&self.signals, signal, &|multiplexer| {
            self.signals[multiplexer].number_of(*values.get(multiplexer)?)
        })
    }

    /// The bytes that counter and checksum signals may cover: all but start bytes and a checksum at the end.
    pub(super) fn payload(&self) -> Range<usize> {
        match &self.carrier {
            Carrier::Frame { length, .. } | Carrier::Parts { length, .. } => 0..*length,
            Carrier::Packet { start, length, trailer } => {
                let sealed = trailer.map_or(0, |trailer| trailer.checksum.length());
                start.len()..length - sealed
            }
            Carrier::Line(_) => 0..0,
        }
    }

    /// The frame with these bytes, truncated to its length; `None` if it is not a frame.
    pub(super) fn frame(&self, data: &[u8]) -> Option<CanFrame> {
        let Carrier::Frame { id, length, fd } = self.carrier else { return None };
        let data = data.get(..length)?;
        match fd {
            Some(flags) => CanFrame::fd(id, flags, data),
            None => CanFrame::new(id, data),
        }
    }

    /// The message with these values; fills in counter and checksum if the sender's state is given.
    pub(super) fn encode(
        &self,
        values: &[f64],
        sent: Option<(&mut Sent, Own)>,
    ) -> Result<Encoded, EncodeError> {
        if values.len() != self.signals.len() {
            return Err(EncodeError::Count {
                message: self.name.clone(),
                expected: self.signals.len(),
                found: values.len(),
            });
        }
        match &self.carrier {
            Carrier::Frame { .. } => {
                let mut data = [self.unused(); FD_BYTES_MAX];
                self.put(values, &mut data)?;
                self.seal(&mut data, sent);
                let frame = self.frame(&data).map(|frame| Encoded::Whole(Transmit::Frame(frame)));
                frame.ok_or_else(|| self.too_long())
            }
            Carrier::Parts { id, length } => {
                let mut data = vec![self.unused(); *length];
                self.put(values, &mut data)?;
                self.seal(&mut data, sent);
                let about = self.group.unwrap_or_else(|| (*id).into());
                Ok(Encoded::InParts(InParts { about, data: data.into() }))
            }
            Carrier::Packet { start, length, trailer } => {
                let mut data = [0; BYTES_MAX];
                self.put(values, &mut data)?;
                let data = data.get_mut(..*length).ok_or_else(|| self.too_long())?;
                for (byte, sync) in data.iter_mut().zip(start) {
                    *byte = *sync;
                }
                self.seal(data, sent);
                if let Some(trailer) = trailer {
                    trailer.seal(data);
                }
                let packet = Packet::from_slice(data).map(Transmit::Bytes).map(Encoded::Whole);
                packet.ok_or_else(|| self.too_long())
            }
            Carrier::Line(pattern) => {
                let mut printed = Vec::with_capacity(values.len());
                for (signal, value) in self.signals.iter().zip(values) {
                    let number = signal.printed(*value);
                    printed.push(number.ok_or_else(|| self.out_of_range(signal, *value))?);
                }
                let line = pattern.write(|index| printed[index]);
                line.map(Transmit::Bytes).map(Encoded::Whole).ok_or_else(|| self.too_long())
            }
        }
    }

    /// A byte without signals: bits that a parameter group does not define are 1 (SAE J1939-71), which means "not available".
    pub(super) const fn unused(&self) -> u8 {
        if self.group.is_some() { 0xFF } else { 0 }
    }

    /// Fills in counter and checksum.
    fn seal(&self, data: &mut [u8], sent: Option<(&mut Sent, Own)>) {
        if let (Some(protected), Some((sent, own))) = (&self.protected, sent)
            && let Some(data) = data.get_mut(self.payload())
        {
            protected.protection.protect(data, sent, own);
        }
    }

    fn put(&self, values: &[f64], data: &mut [u8]) -> Result<(), EncodeError> {
        for (place, (signal, value)) in self.signals.iter().zip(values).enumerate() {
            if self.carries(place, values) && !signal.put(*value, data) {
                return Err(self.out_of_range(signal, *value));
            }
        }
        Ok(())
    }

    /// Stores the values in the bytes of a packet in `values`, one per signal.
    pub(super) fn read(&self, data: &[u8], values: &mut Vec<Option<f64>>) {
        let number = |multiplexer: usize| Some(self.signals[multiplexer].selector(data));
        values.clear();
        values.extend(self.signals.iter().enumerate().map(|(place, signal)| {
            multiplexing::carries(&self.signals, place, &number).then(|| signal.read(data))
        }));
    }

    /// Matches the first bytes of a serial line with this message. If it is complete, stores its values in `values`.
    pub(super) fn find(&self, data: &[u8], values: &mut Vec<Option<f64>>) -> Found {
        match &self.carrier {
            Carrier::Frame { .. } | Carrier::Parts { .. } => Found::Nothing,
            Carrier::Packet { start, length, trailer } => {
                let known = start.len().min(data.len());
                if data[..known] != start[..known] {
                    return Found::Nothing;
                }
                let Some(packet) = data.get(..*length) else { return Found::Beginning };
                if trailer.is_some_and(|trailer| !trailer.holds(packet)) {
                    return Found::WrongChecksum(*length);
                }
                self.read(packet, values);
                Found::Whole(*length)
            }
            Carrier::Line(pattern) => {
                let mut numbers = Vec::with_capacity(self.signals.len());
                match pattern.read(data, &mut numbers) {
                    Match::No => Found::Nothing,
                    Match::WrongChecksum(length) => Found::WrongChecksum(length),
                    Match::Partial => Found::Beginning,
                    Match::Whole(length) => {
                        let physical =
                            |(number, signal): (f64, &Signal)| Some(signal.scale.physical(number));
                        values.clear();
                        values.extend(numbers.into_iter().zip(&self.signals).map(physical));
                        Found::Whole(length)
                    }
                }
            }
        }
    }

    fn out_of_range(&self, signal: &Signal, value: f64) -> EncodeError {
        EncodeError::OutOfRange {
            signal: format!("{}.{}", self.name, signal.name),
            value,
            minimum: signal.minimum,
            maximum: signal.maximum,
            unit: signal.unit.clone(),
        }
    }

    fn too_long(&self) -> EncodeError {
        EncodeError::TooLong { message: self.name.clone() }
    }
}

/// An encoded message.
#[derive(Debug, Clone, PartialEq)]
pub enum Encoded {
    /// Sent at once.
    Whole(Transmit),
    /// Sent by a [`Transport`](crate::transport::Transport).
    InParts(InParts),
}

impl Encoded {
    /// The message, if it is sent at once; `None` if in parts.
    pub fn whole(self) -> Option<Transmit> {
        match self {
            Self::Whole(what) => Some(what),
            Self::InParts(_) => None,
        }
    }
}

/// Match of serial bytes with a message.
pub(super) enum Found {
    /// It does not begin here.
    Nothing,
    /// It may begin here: more bytes are needed.
    Beginning,
    /// Complete, with this length, except for a wrong checksum.
    WrongChecksum(usize),
    /// Complete, with this length.
    Whole(usize),
}

/// Checks counter and checksum among the signals of a message with these bytes. With a wrong checksum, no value counts.
#[inline]
pub(super) fn judge(
    message: &Message,
    data: &[u8],
    received: &mut Received,
    values: &mut [Option<f64>],
) -> Option<Verdict> {
    let protected = message.protected.as_ref()?;
    let verdict = protected.protection.check(data.get(message.payload())?, received);
    if verdict == Verdict::WrongChecksum {
        values.fill(None);
    }
    Some(verdict)
}
