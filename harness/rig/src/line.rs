//! A line between nodes: a serial line between two, one that several share (RS-485), or a CAN bus.

mod struck;

pub use crate::link::EndId;

use crate::link::{CanBus, SerialLine, StateChange, Tampering, collide};
use described::{Layout, Message, Sender};
use record::Device;
use std::collections::VecDeque;
use std::sync::Arc;
use wire::can::{BitRates, CanFrame};
use wire::device::{PortId, Transmit};
use wire::serial::SerialSettings;
use wire::time::{Span, Timestamp};

/// An end: its node, the port there, and the sender's name in the record.
#[derive(Debug, Clone)]
pub struct End {
    pub node: usize,
    pub port: PortId,
    pub who: Device,
    /// Name in the record of changed error states.
    pub name: Arc<str>,
}

/// Medium between the ends.
#[derive(Debug, Clone)]
enum Wire {
    /// One for each end: from it to all others.
    Serial(Vec<SerialLine>),
    Can(CanBus),
    /// Not paced here: a port of the system paces it, so what is sent arrives at once.
    Direct(VecDeque<(EndId, Transmit)>),
}

/// Most items on a direct line unless [more are expected](Line::expect_messages); those beyond are dropped and counted.
const DIRECT_MAX: usize = 1_024;

#[derive(Debug, Clone)]
pub struct Line {
    wire: Wire,
    tampering: Tampering,
    ends: Vec<End>,
    /// Whether its traffic is recorded and decoded.
    is_recorded: bool,
    /// Frames that have had their time on the bus at a port.
    carried: VecDeque<(EndId, CanFrame)>,
    /// Items expected on a direct line.
    expected: usize,
    dropped: u64,
    collisions: u64,
    /// Ends of a serial line that several share which hear nothing, each by the number of a fault.
    unplugged: Vec<(usize, EndId)>,
    /// See [`Self::next_arrival`]: cached, because it is needed at every event.
    next_arrival: Timestamp,
    /// The last fault that began on the line: changes of error states are attributed to it.
    struck_last: usize,
    /// The sender, in the record, of frames that faults make.
    stranger: Device,
}

impl Line {
    /// A serial line with these ends. Two can send at the same time; of more, what two send at the same time collides.
    pub fn serial(settings: SerialSettings, ends: Vec<End>) -> Self {
        let ways = ends.iter().map(|_| SerialLine::new(settings)).collect();
        Self::of(Wire::Serial(ways), ends)
    }

    /// A CAN bus of these bit rates.
    pub fn can(rates: BitRates, ends: Vec<End>) -> Self {
        Self::of(Wire::Can(CanBus::at(rates)), ends)
    }

    /// Adds an end; returns its index.
    pub(super) fn add(&mut self, end: End) -> usize {
        if let Wire::Serial(ways) = &mut self.wire {
            let way = ways.first().map(SerialLine::another);
            ways.extend(way);
        }
        self.ends.push(end);
        self.ends.len() - 1
    }

    /// A line between nodes of which one is at a port of the system.
    pub fn direct(ends: Vec<End>) -> Self {
        Self::of(Wire::Direct(VecDeque::new()), ends)
    }

    fn of(wire: Wire, ends: Vec<End>) -> Self {
        Self {
            wire,
            tampering: Tampering::default(),
            ends,
            is_recorded: true,
            carried: VecDeque::new(),
            expected: 0,
            dropped: 0,
            collisions: 0,
            unplugged: Vec::new(),
            next_arrival: Timestamp::MAX,
            struck_last: 0,
            stranger: Device::Plan,
        }
    }

    /// Makes room for all messages that this sender may have to send at once, twice: those of one period may still wait
    /// when the next are due. Traffic that a fault makes has the identifier of no message of the layout.
    pub fn expect_messages(&mut self, layout: &Layout, sender: Option<Sender>) {
        let sent = layout.messages().iter().filter(|message| Some(message.sender) == sender);
        let expected = 2 * sent.count();
        match &mut self.wire {
            Wire::Serial(ways) => ways.iter_mut().for_each(|way| way.expect(expected)),
            Wire::Can(bus) => {
                bus.expect(expected);
                bus.take_identifiers(layout.messages().iter().filter_map(Message::can_id));
            }
            Wire::Direct(_) => self.expected += expected,
        }
    }

    /// Frames that faults make are recorded as of this device.
    pub fn with_stranger(self, stranger: Device) -> Self {
        Self { stranger, ..self }
    }

    /// A real serial line at its port takes the time that its bytes take.
    pub fn leave_time_to_a_real_line(&mut self) {
        if let Wire::Serial(ways) = &mut self.wire {
            ways.iter_mut().for_each(SerialLine::leave_time_to_a_real_line);
        }
    }

    /// Leaves its traffic out of the record; it is recorded elsewhere.
    pub fn unrecorded(self) -> Self {
        Self { is_recorded: false, ..self }
    }

    pub const fn is_recorded(&self) -> bool {
        self.is_recorded
    }

    pub fn ends(&self) -> &[End] {
        &self.ends
    }

    /// Whether what is sent arrives at once.
    pub const fn is_direct(&self) -> bool {
        matches!(self.wire, Wire::Direct(_))
    }

    pub const fn is_can(&self) -> bool {
        matches!(self.wire, Wire::Can(_))
    }

    /// Whether it is a CAN FD bus.
    pub const fn is_fd(&self) -> bool {
        matches!(&self.wire, Wire::Can(bus) if bus.rates().data.is_some())
    }

    /// The sender, in the record, of what comes from this end.
    pub fn who(&self, from: EndId) -> Device {
        self.ends.get(from.place()).map_or(self.stranger, |end| end.who)
    }

    pub fn name(&self, of: EndId) -> &str {
        self.ends.get(of.place()).map_or("stranger", |end| &end.name)
    }

    #[inline]
    pub const fn next_arrival(&self) -> Timestamp {
        self.next_arrival
    }

    #[inline]
    fn look_ahead(&mut self) {
        self.next_arrival = match &self.wire {
            _ if !self.carried.is_empty() => Timestamp::ZERO,
            Wire::Serial(ways) => {
                ways.iter().map(SerialLine::next_arrival).min().unwrap_or(Timestamp::MAX)
            }
            Wire::Can(bus) => bus.next_arrival(),
            Wire::Direct(queue) if queue.is_empty() => Timestamp::MAX,
            Wire::Direct(_) => Timestamp::ZERO,
        };
    }

    /// Sends on the line; something of another medium is ignored.
    #[inline]
    pub fn send(&mut self, now: Timestamp, from: EndId, mut what: Transmit) {
        self.tampering.pass(from, &mut what);
        // By reference: what was just written is not copied once more than it has to be.
        match (&mut self.wire, &what) {
            (Wire::Serial(ways), Transmit::Bytes(packet)) => {
                if let Some(way) = ways.get_mut(from.place()) {
                    way.send(now, *packet);
                }
                if ways.len() > 2 {
                    self.collisions += collide(ways, from.place());
                }
            }
            (Wire::Can(bus), Transmit::Frame(frame)) => bus.send(now, from, *frame),
            (Wire::Direct(queue), what) if queue.len() < self.expected.max(DIRECT_MAX) => {
                queue.push_back((from, *what));
            }
            (Wire::Direct(_), _) => self.dropped += 1,
            _ => {}
        }
        self.look_ahead();
    }

    /// Takes a frame of `from` that had its time on a bus outside: it arrives at once. While a fault strikes the bus here, it is
    /// sent once more, for the fault to strike it.
    pub fn carried(&mut self, now: Timestamp, from: EndId, frame: CanFrame) {
        match &self.wire {
            Wire::Can(bus) if !bus.is_struck() && self.tampering.is_empty() => {
                self.carried.push_back((from, frame));
                self.look_ahead();
            }
            _ => self.send(now, from, Transmit::Frame(frame)),
        }
    }

    /// Shortcut for a packet that the end sends at `at` and that takes until `now`: it need not be put on the line and
    /// taken off again. Returns `false`, with nothing done, if the line is busy or faulty.
    #[inline]
    pub(super) fn passes(&mut self, at: Timestamp, now: Timestamp, from: EndId) -> bool {
        let Wire::Serial(ways) = &mut self.wire else { return false };
        let is_idle = self.next_arrival == Timestamp::MAX && self.tampering.is_empty();
        is_idle && ways.get_mut(from.place()).is_some_and(|way| way.passes(at, now))
    }

    /// Takes something that has arrived by `now`, with its sender.
    #[inline]
    pub fn arrived(&mut self, now: Timestamp) -> Option<(EndId, Transmit)> {
        if self.next_arrival > now {
            return None;
        }
        if let Some((from, frame)) = self.carried.pop_front() {
            let what = Transmit::Frame(frame);
            self.lose(from, &what);
            self.look_ahead();
            return Some((from, what));
        }
        let arrived = match &mut self.wire {
            Wire::Serial(ways) => {
                let mut ways = ways.iter_mut().enumerate();
                ways.find_map(|(place, way)| {
                    Some((EndId::of(place), Transmit::Bytes(way.arrived(now)?)))
                })
            }
            Wire::Can(bus) => bus.arrived(now).map(|(from, frame)| (from, Transmit::Frame(frame))),
            Wire::Direct(queue) => queue.pop_front(),
        };
        self.look_ahead();
        arrived
    }

    /// Whether the node at this end has lost what arrived last.
    #[inline]
    pub fn misses(&self, of: EndId) -> bool {
        matches!(&self.wire, Wire::Can(bus) if bus.is_missed_by(of))
            || self.unplugged.iter().any(|(_, end)| *end == of)
    }

    /// Draws anew which nodes [miss](Self::misses) this frame of `from`, which is known to have come through.
    pub fn lose(&mut self, from: EndId, what: &Transmit) {
        if let (Wire::Can(bus), Transmit::Frame(frame)) = (&mut self.wire, what) {
            bus.lose(from, frame);
        }
    }

    /// Shortest time that this number of bytes takes on the line; zero on a bus.
    pub(super) fn time_for(&self, bytes: usize) -> Span {
        match &self.wire {
            Wire::Serial(ways) => ways.first().map_or(Span::ZERO, |way| way.time_for(bytes)),
            Wire::Can(_) | Wire::Direct(_) => Span::ZERO,
        }
    }

    /// Number of items dropped for lack of room.
    pub fn no_room(&self) -> u64 {
        match &self.wire {
            Wire::Can(bus) => bus.no_room(),
            Wire::Serial(_) | Wire::Direct(_) => self.dropped(),
        }
    }

    /// How often two nodes sent at the same time on a serial line that more share.
    pub const fn collisions(&self) -> u64 {
        self.collisions
    }

    pub fn dropped(&self) -> u64 {
        match &self.wire {
            Wire::Serial(ways) => ways.iter().map(SerialLine::dropped).sum(),
            Wire::Can(bus) => bus.dropped(),
            Wire::Direct(_) => self.dropped,
        }
    }

    /// Whether a change of an end's error state has not been taken yet.
    #[inline]
    pub(super) fn has_state_change(&self) -> bool {
        matches!(&self.wire, Wire::Can(bus) if bus.has_state_change())
    }

    /// Takes the next change of an end's error state, with the fault that it is attributed to.
    pub fn state_change(&mut self) -> Option<(usize, StateChange)> {
        match &mut self.wire {
            Wire::Serial(_) | Wire::Direct(_) => None,
            Wire::Can(bus) => bus.state_change().map(|change| (self.struck_last, change)),
        }
    }
}
