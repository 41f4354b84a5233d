//! One CAN bus: one frame at a time, the lowest identifier first, and optional faults.

mod confinement;
mod effect;
mod faulty;
mod nodes;
mod waiting;

pub use confinement::{ErrorCounters, ErrorState};
pub use nodes::StateChange;

use crate::link::end_id::EndId;
use faulty::{Faulty, Missed};
use std::collections::BTreeSet;
use std::sync::Arc;
use waiting::Waiting;
use wire::can::{BitRates, CanFrame, Id, StandardId};
use wire::time::Timestamp;

/// Most frames of a node that wait for the bus unless [more are expected](CanBus::expect); those beyond are dropped and
/// counted. Each node has a queue of its own: what another sends takes no place in it.
const FRAMES_MAX: usize = 1_024;

/// A bus that every node receives; `from` names the sender.
#[derive(Debug, Clone, Default)]
pub struct CanBus {
    rates: BitRates,
    waiting: Waiting,
    on_bus: Option<(Timestamp, EndId, CanFrame)>,
    expected: usize,
    /// Identifiers of messages of the nodes.
    taken: Arc<BTreeSet<StandardId>>,
    no_room: u64,
    dropped: u64,
    /// See [`Self::is_missed_by`].
    missed: Missed,
    faulty: Option<Box<Faulty>>,
}

impl CanBus {
    /// An idle bus of these rates.
    pub fn at(rates: BitRates) -> Self {
        Self { rates, ..Self::default() }
    }

    pub const fn rates(&self) -> BitRates {
        self.rates
    }

    /// So many frames more of a node may wait at once.
    pub const fn expect(&mut self, frames: usize) {
        self.expected += frames;
    }

    /// These identifiers are of messages: the traffic of other nodes that a fault makes keeps clear of them.
    pub fn take_identifiers(&mut self, identifiers: impl Iterator<Item = Id>) {
        let standard = identifiers.filter_map(|id| match id {
            Id::Standard(id) => Some(id),
            Id::Extended(_) => None,
        });
        Arc::make_mut(&mut self.taken).extend(standard);
    }

    /// Sends a frame. It goes at once if the bus is idle, else it takes part in the next arbitration. A classic bus
    /// drops CAN FD frames.
    pub fn send(&mut self, now: Timestamp, from: EndId, frame: CanFrame) {
        let is_foreign = frame.fd_flags().is_some() && self.rates.data.is_none();
        if is_foreign || !self.may_send(now, from) {
            self.dropped += 1;
            return;
        }
        if !self.is_delayed(now, from, &frame) {
            self.wait(now, from, frame);
        }
    }

    /// From now on the frame waits for the bus.
    fn wait(&mut self, now: Timestamp, from: EndId, frame: CanFrame) {
        let most = self.expected.max(FRAMES_MAX);
        if self.waiting.len() >= most && self.waiting.count(from) >= most {
            self.no_room += 1;
            return;
        }
        if self.on_bus.is_none() && self.faulty.is_none() {
            // The usual case; then no other frame waits.
            return self.begin(now, from, frame);
        }
        self.waiting.push(from, frame);
        if let Some(faulty) = &mut self.faulty {
            faulty.sent(from);
        }
        if self.on_bus.is_none() {
            self.arbitrate(now);
        }
    }

    /// When the frame on the bus is complete, or when a fault acts next.
    pub fn next_arrival(&self) -> Timestamp {
        let through = self.on_bus.as_ref().map_or(Timestamp::MAX, |(at, ..)| *at);
        if self.faulty.is_some() { through.min(self.next_faulty()) } else { through }
    }

    /// Takes a frame that is complete by `now`, with its sender.
    pub fn arrived(&mut self, now: Timestamp) -> Option<(EndId, CanFrame)> {
        self.missed = Missed::default();
        if self.faulty.is_some() {
            return self.arrived_faulty(now);
        }
        let (at, from, frame) = self.on_bus.take_if(|(at, ..)| *at <= now)?;
        self.arbitrate(at);
        Some((from, frame))
    }

    /// Whether this node has lost the frame that arrived last.
    #[inline]
    pub fn is_missed_by(&self, node: EndId) -> bool {
        self.missed.has(node)
    }

    /// Frames dropped because the queue was full, their node was bus-off, or the bus is classic.
    pub const fn dropped(&self) -> u64 {
        self.dropped + self.no_room
    }

    /// Those of them for which the queue of their node had no room.
    pub const fn no_room(&self) -> u64 {
        self.no_room
    }

    fn arbitrate(&mut self, now: Timestamp) {
        if self.faulty.is_some() {
            return self.arbitrate_faulty(now);
        }
        if let Some((from, frame)) = self.waiting.take(0) {
            self.begin(now, from, frame);
        }
    }

    fn begin(&mut self, now: Timestamp, from: EndId, frame: CanFrame) {
        self.on_bus = Some((now + frame.duration(self.rates), from, frame));
    }
}

#[cfg(test)]
mod tests {
    use super::{BitRates, CanBus, CanFrame, EndId, FRAMES_MAX, Timestamp};
    use wire::can::{ExtendedId, FdFlags, StandardId};

    fn frame(id: u16) -> CanFrame {
        CanFrame::new(StandardId::new(id).unwrap(), &[0; 8]).unwrap()
    }

    #[test]
    fn the_lowest_identifier_goes_first_once_the_bus_is_free() {
        let mut bus = CanBus::default();
        for (place, id) in [(3, 0x300), (2, 0x200), (1, 0x100), (2, 0x200)] {
            bus.send(Timestamp::ZERO, EndId(place), frame(id));
        }
        bus.send(
            Timestamp::ZERO,
            EndId(9),
            CanFrame::new(ExtendedId::new(0x100 << 18).unwrap(), &[]).unwrap(),
        );
        let mut order = Vec::new();
        while let Some((from, _)) = bus.arrived(bus.next_arrival()) {
            order.push(from);
        }
        assert_eq!(order, [3, 1, 9, 2, 2].map(EndId));
    }

    #[test]
    fn a_frame_takes_its_bits_and_those_that_are_stuffed() {
        let takes = |id: u16, byte: u8| {
            let mut bus = CanBus::default();
            let id = StandardId::new(id).unwrap();
            bus.send(Timestamp::ZERO, EndId(0), CanFrame::new(id, &[byte; 8]).unwrap());
            bus.next_arrival().as_nanos() / 2_000
        };
        // The start bit, 63 zeros of data and other bits stuff 17 bits into a frame of 111.
        assert_eq!([takes(0x2aa, 0x55), takes(1, 0)], [111, 128]);
    }

    #[test]
    fn sixty_four_bytes_of_fd_take_their_two_rates_and_no_classic_bus() {
        let flags = FdFlags { bit_rate_switch: true, error_state: false };
        let frame = CanFrame::fd(StandardId::new(0x555).unwrap(), flags, &[0x55; 64]).unwrap();
        let mut bus = CanBus::at(BitRates { nominal: 500_000, data: Some(2_000_000) });
        bus.send(Timestamp::ZERO, EndId(0), frame);
        assert_eq!(bus.next_arrival().as_nanos(), 29 * 2_000 + 550 * 500);
        assert_eq!(bus.arrived(bus.next_arrival()), Some((EndId(0), frame)));
        let mut classic = CanBus::default();
        classic.send(Timestamp::ZERO, EndId(0), frame);
        assert_eq!((classic.next_arrival(), classic.dropped()), (Timestamp::MAX, 1));
    }

    #[test]
    fn a_full_queue_is_counted() {
        let mut bus = CanBus::default();
        for _ in 0..FRAMES_MAX + 5 {
            bus.send(Timestamp::ZERO, EndId(0), frame(1));
        }
        assert_eq!((bus.dropped(), bus.no_room()), (4, 4));
    }

    #[test]
    fn a_node_that_floods_the_bus_takes_no_room_of_another() {
        let mut bus = CanBus::default();
        for _ in 0..FRAMES_MAX + 5 {
            bus.send(Timestamp::ZERO, EndId(0), frame(0x700));
        }
        let before = bus.no_room();
        bus.send(Timestamp::ZERO, EndId(1), frame(0x100));
        assert_eq!(bus.no_room(), before);
        bus.arrived(bus.next_arrival());
        assert_eq!(bus.arrived(bus.next_arrival()), Some((EndId(1), frame(0x100))));
    }

    #[test]
    fn all_that_is_expected_has_room() {
        let mut bus = CanBus::default();
        bus.expect(FRAMES_MAX);
        bus.expect(5);
        for _ in 0..FRAMES_MAX + 8 {
            bus.send(Timestamp::ZERO, EndId(0), frame(1));
        }
        assert_eq!(bus.no_room(), 2);
    }
}
