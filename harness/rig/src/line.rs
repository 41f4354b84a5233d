//! A line between nodes: both directions of a serial line, or a CAN bus that all of its ends hear.

use crate::link::{CanBus, SerialLine, StateChange, Struck, Tampering};
use plan::faults::Chance;
use plan::faults::{FaultKind, Toward};
use record::Device;
use std::collections::VecDeque;
use std::sync::Arc;
use wire::can::{BitRates, Id};
use wire::device::{PortId, Transmit};
use wire::serial::SerialSettings;
use wire::time::{Span, Timestamp};

/// An end of a line, by its place among them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EndId(pub u8);

impl EndId {
    /// Another node, which a fault put on the bus.
    pub(crate) const STRANGER: Self = Self(u8::MAX);

    pub fn of(place: usize) -> Self {
        Self(u8::try_from(place).unwrap_or(u8::MAX))
    }

    pub const fn place(self) -> usize {
        self.0 as usize
    }
}

/// Which node is at an end, at which of its ports, and as whose the record has what it sends.
#[derive(Debug, Clone)]
pub struct End {
    pub node: usize,
    pub port: PortId,
    pub who: Device,
    /// As the record names a node whose error state changed.
    pub name: Arc<str>,
}

/// What is between the ends.
#[derive(Debug, Clone)]
enum Wire {
    /// From the first end to the second, and back.
    Serial([SerialLine; 2]),
    Can(CanBus<EndId>),
    /// No line of its own: what is sent is through, as a port of the system paces it.
    Direct(VecDeque<(EndId, Transmit)>),
}

/// What a direct line holds at most; more is dropped and counted.
const DIRECT_MAX: usize = 1_024;

/// One line of a rig.
#[derive(Debug, Clone)]
pub struct Line {
    wire: Wire,
    tampering: Tampering<EndId>,
    ends: Vec<End>,
    /// What crosses it is in the record, and read.
    is_recorded: bool,
    dropped: u64,
    /// See [`Self::next_arrival`]: asked at every event, it is kept and not looked for.
    next_arrival: Timestamp,
    /// The last fault that began on it: changes of error states are put down to it.
    struck_last: usize,
}

impl Line {
    pub fn serial(settings: SerialSettings, ends: [End; 2]) -> Self {
        let wire = Wire::Serial([SerialLine::new(settings), SerialLine::new(settings)]);
        Self::of(wire, ends.into())
    }

    /// A bus of these rates.
    pub fn can(rates: BitRates, ends: Vec<End>) -> Self {
        Self::of(Wire::Can(CanBus::at(rates)), ends)
    }

    /// One more end; its place.
    pub(super) fn add(&mut self, end: End) -> usize {
        self.ends.push(end);
        self.ends.len() - 1
    }

    /// Between nodes of which one is at a port of the system.
    pub fn direct(ends: Vec<End>) -> Self {
        Self::of(Wire::Direct(VecDeque::new()), ends)
    }

    fn of(wire: Wire, ends: Vec<End>) -> Self {
        Self {
            wire,
            tampering: Tampering::default(),
            ends,
            is_recorded: true,
            dropped: 0,
            next_arrival: Timestamp::MAX,
            struck_last: 0,
        }
    }

    /// What crosses it is recorded elsewhere.
    pub fn unrecorded(self) -> Self {
        Self { is_recorded: false, ..self }
    }

    pub const fn is_recorded(&self) -> bool {
        self.is_recorded
    }

    pub fn ends(&self) -> &[End] {
        &self.ends
    }

    pub const fn is_can(&self) -> bool {
        matches!(self.wire, Wire::Can(_))
    }

    /// As whose the record has what came from there.
    pub fn who(&self, from: EndId) -> Device {
        self.ends.get(from.place()).map_or(Device::Plan, |end| end.who)
    }

    pub fn name(&self, of: EndId) -> &str {
        self.ends.get(of.place()).map_or("stranger", |end| &end.name)
    }

    /// When something is through next.
    #[inline]
    pub const fn next_arrival(&self) -> Timestamp {
        self.next_arrival
    }

    #[inline]
    fn look_ahead(&mut self) {
        self.next_arrival = match &self.wire {
            Wire::Serial([there, back]) => there.next_arrival().min(back.next_arrival()),
            Wire::Can(bus) => bus.next_arrival(),
            Wire::Direct(queue) if queue.is_empty() => Timestamp::MAX,
            Wire::Direct(_) => Timestamp::ZERO,
        };
    }

    /// Puts something on the line; anything of another medium is ignored.
    #[inline]
    pub fn send(&mut self, now: Timestamp, from: EndId, what: Transmit) {
        match (&mut self.wire, self.tampering.pass(from, what)) {
            (Wire::Serial(ways), Transmit::Bytes(packet)) => {
                if let Some(way) = ways.get_mut(from.place()) {
                    way.send(now, packet);
                }
            }
            (Wire::Can(bus), Transmit::Frame(frame)) => bus.send(now, from, frame),
            (Wire::Direct(queue), what) if queue.len() < DIRECT_MAX => {
                queue.push_back((from, what));
            }
            (Wire::Direct(_), _) => self.dropped += 1,
            _ => {}
        }
        self.look_ahead();
    }

    /// What that end sends at `at` and takes until `now` goes through by itself: it need not be put on the line and taken off
    /// again. False, and nothing done, where something else is on the line, or a fault.
    #[inline]
    pub(super) fn passes(&mut self, at: Timestamp, now: Timestamp, from: EndId) -> bool {
        let Wire::Serial(ways) = &mut self.wire else { return false };
        let is_idle = self.next_arrival == Timestamp::MAX && self.tampering.is_empty();
        is_idle && ways.get_mut(from.place()).is_some_and(|way| way.passes(at, now))
    }

    /// Something that is through by `now`, and who sent it.
    #[inline]
    pub fn arrived(&mut self, now: Timestamp) -> Option<(EndId, Transmit)> {
        if self.next_arrival > now {
            return None;
        }
        let arrived = match &mut self.wire {
            Wire::Serial([there, back]) => {
                let (from, way) = match there.next_arrival() <= now {
                    true => (EndId(0), there),
                    false => (EndId(1), back),
                };
                way.arrived(now).map(|packet| (from, Transmit::Bytes(packet)))
            }
            Wire::Can(bus) => bus.arrived(now).map(|(from, frame)| (from, Transmit::Frame(frame))),
            Wire::Direct(queue) => queue.pop_front(),
        };
        self.look_ahead();
        arrived
    }

    /// How long so many bytes take on it at least; nothing on a bus.
    pub(super) fn time_for(&self, bytes: usize) -> Span {
        match &self.wire {
            Wire::Serial([way, _]) => way.time_for(bytes),
            Wire::Can(_) | Wire::Direct(_) => Span::ZERO,
        }
    }

    /// What found no room.
    pub fn dropped(&self) -> u64 {
        match &self.wire {
            Wire::Serial(ways) => ways.iter().map(SerialLine::dropped).sum(),
            Wire::Can(bus) => bus.dropped(),
            Wire::Direct(_) => self.dropped,
        }
    }

    /// The next change of an end's error state that was not told yet, and the fault that it is put down to.
    pub fn state_change(&mut self) -> Option<(usize, StateChange<EndId>)> {
        match &mut self.wire {
            Wire::Serial(_) | Wire::Direct(_) => None,
            Wire::Can(bus) => bus.state_change().map(|change| (self.struck_last, change)),
        }
    }

    /// From now on the line is faulty in this way too: what the device at the end `of` sends, what the others send to it,
    /// or both. Each direction draws for itself. On a bus only frames of that identifier, where there is one.
    pub fn begin_fault(
        &mut self,
        now: Timestamp,
        (number, kind): (usize, &FaultKind),
        (of, toward, only): (EndId, Toward, Option<Id>),
        chance: impl Fn(&str) -> Chance,
    ) {
        self.struck_last = number;
        match &mut self.wire {
            Wire::Can(bus) => {
                let ends: Vec<EndId> = (0..self.ends.len()).map(EndId::of).collect();
                let mut strike = |name: &str, from| {
                    let fault = (number, kind, chance(name));
                    bus.begin_fault(now, fault, (from, only), &ends, EndId::STRANGER);
                };
                let of_bus = kind.makes_frames();
                if of_bus {
                    strike("bus", None);
                }
                if toward != Toward::Device && !of_bus {
                    strike("to host", Some(of));
                }
                if toward != Toward::Host && !of_bus {
                    let others = ends.iter().filter(|end| **end != of);
                    for (count, other) in others.enumerate() {
                        let name = match count {
                            0 => "to device".to_owned(),
                            more => format!("to device {more}"),
                        };
                        strike(&name, Some(*other));
                    }
                }
            }
            Wire::Serial(ways) => {
                for (place, way) in ways.iter_mut().enumerate() {
                    let (direction, name) = match EndId::of(place) == of {
                        true => (Toward::Host, "to host"),
                        false => (Toward::Device, "to device"),
                    };
                    if toward == Toward::Both || toward == direction {
                        way.begin_fault(now, number, kind, chance(name));
                    }
                }
            }
            Wire::Direct(_) => {}
        }
        self.look_ahead();
    }

    /// From now on a message that the device at that end sends is changed before it is on the line.
    pub(crate) fn tamper(
        &mut self,
        fault: (usize, &FaultKind, Chance),
        from: EndId,
        struck: Struck,
    ) {
        self.struck_last = fault.0;
        self.tampering.begin(fault, from, struck);
    }

    /// The fault of this number is over; how often it acted.
    pub fn end_fault(&mut self, now: Timestamp, number: usize) -> u64 {
        let tampered = self.tampering.end(number);
        let acted = match &mut self.wire {
            Wire::Can(bus) => bus.end_fault(now, number),
            Wire::Serial(ways) => ways.iter_mut().map(|way| way.end_fault(number)).sum(),
            Wire::Direct(_) => 0,
        };
        self.look_ahead();
        tampered + acted
    }
}
