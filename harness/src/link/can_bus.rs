//! One CAN bus: one frame at a time, the lowest identifier first. A faulty bus is a bus.

mod confinement;
mod effect;
mod faulty;
mod nodes;

pub use confinement::{ErrorCounters, ErrorState};
pub use nodes::StateChange;

use faulty::Faulty;
use wire::can::{BIT_RATE, CanFrame, Id};
use wire::time::{Span, Timestamp};

/// Frames that can wait for the bus; more are dropped and counted. Assumption: no DBC has as many messages that are sent at
/// one time.
pub const FRAMES_MAX: usize = 1_024;

/// A bus that every node hears; `from` tells who sent.
#[derive(Debug)]
pub struct CanBus<Node> {
    /// Time of one bit.
    bit: Span,
    waiting: Vec<(Node, CanFrame)>,
    on_bus: Option<(Timestamp, Node, CanFrame)>,
    dropped: u64,
    faulty: Option<Box<Faulty<Node>>>,
}

impl<Node: Copy + PartialEq> CanBus<Node> {
    /// A bus of the [usual rate](BIT_RATE) that is idle.
    pub const fn new() -> Self {
        Self::of(BIT_RATE)
    }

    /// One of this rate, bits per second.
    pub fn at(bit_rate: u32) -> Self {
        Self::of(i64::from(bit_rate.max(1)))
    }

    const fn of(bit_rate: i64) -> Self {
        let bit = Span::from_nanos(1_000_000_000 / bit_rate);
        Self { bit, waiting: Vec::new(), on_bus: None, dropped: 0, faulty: None }
    }

    /// A node wants to send. Its frame goes at once if the bus is idle, else it takes part in the next
    /// arbitration.
    pub fn send(&mut self, now: Timestamp, from: Node, frame: CanFrame) {
        if self.waiting.len() >= FRAMES_MAX || !self.may_send(now, from) {
            self.dropped += 1;
            return;
        }
        self.waiting.push((from, frame));
        if self.on_bus.is_none() {
            self.arbitrate(now);
        }
    }

    /// When the frame on the bus is through, or a fault has something to do.
    pub fn next_arrival(&self) -> Timestamp {
        let through = self.on_bus.as_ref().map_or(Timestamp::MAX, |(at, ..)| *at);
        if self.faulty.is_some() { through.min(self.next_faulty()) } else { through }
    }

    /// A frame that is through by `now`, and who sent it.
    pub fn arrived(&mut self, now: Timestamp) -> Option<(Node, CanFrame)> {
        if self.faulty.is_some() {
            return self.arrived_faulty(now);
        }
        let (at, from, frame) = self.on_bus.take_if(|(at, ..)| *at <= now)?;
        self.arbitrate(at);
        Some((from, frame))
    }

    /// Frames that found a queue full, or their node off.
    pub const fn dropped(&self) -> u64 {
        self.dropped
    }

    fn arbitrate(&mut self, now: Timestamp) {
        if self.faulty.is_some() {
            return self.arbitrate_faulty(now);
        }
        // The first of equals wins: a node's own frames keep their order.
        let winner = (0..self.waiting.len()).min_by_key(|&index| priority(&self.waiting[index].1));
        if let Some(index) = winner {
            let (from, frame) = self.waiting.remove(index);
            self.on_bus = Some((now + frame_time(self.bit, &frame), from, frame));
        }
    }
}

impl<Node: Copy + PartialEq> Default for CanBus<Node> {
    fn default() -> Self {
        Self::new()
    }
}

/// How long a frame takes, the gap behind it included.
fn frame_time(bit: Span, frame: &CanFrame) -> Span {
    bit * i64::from(frame.bits_unstuffed())
}

/// Lower wins. A standard identifier beats an extended one with the same leading bits.
fn priority(frame: &CanFrame) -> u64 {
    match frame.id() {
        Id::Standard(id) => u64::from(id.as_raw()) << 19,
        Id::Extended(id) => {
            let raw = u64::from(id.as_raw());
            (raw >> 18) << 19 | 1 << 18 | (raw & 0x3_ffff)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{CanBus, CanFrame, FRAMES_MAX, Timestamp};
    use wire::can::{ExtendedId, StandardId};

    fn frame(id: u16) -> CanFrame {
        CanFrame::new(StandardId::new(id).unwrap(), &[0; 8]).unwrap()
    }

    #[test]
    fn the_lowest_identifier_goes_first_once_the_bus_is_free() {
        let mut bus = CanBus::new();
        for id in [0x300, 0x200, 0x100, 0x200] {
            bus.send(Timestamp::ZERO, id, frame(id));
        }
        bus.send(
            Timestamp::ZERO,
            0x999,
            CanFrame::new(ExtendedId::new(0x100 << 18).unwrap(), &[]).unwrap(),
        );
        let mut order = Vec::new();
        while let Some((from, _)) = bus.arrived(bus.next_arrival()) {
            order.push(from);
        }
        assert_eq!(order, [0x300, 0x100, 0x999, 0x200, 0x200]);
    }

    #[test]
    fn eight_bytes_take_111_bit_times() {
        let mut bus = CanBus::new();
        bus.send(Timestamp::ZERO, (), frame(1));
        assert_eq!(bus.next_arrival().as_nanos(), 111 * 2_000);
    }

    #[test]
    fn a_full_queue_is_counted() {
        let mut bus = CanBus::new();
        for _ in 0..FRAMES_MAX + 5 {
            bus.send(Timestamp::ZERO, (), frame(1));
        }
        assert_eq!(bus.dropped(), 4);
    }
}
