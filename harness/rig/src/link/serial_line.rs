//! One direction of a serial line: bytes arrive when their last stop bit has passed. A faulty line is a line.

mod faulty;
mod uart;

use faulty::Faulty;
use std::collections::VecDeque;
use wire::packet::Packet;
use wire::serial::SerialSettings;
use wire::time::{Span, Timestamp};

/// Packets that can wait for the line; more are dropped and counted.
pub const PACKETS_MAX: usize = 256;

/// One direction of a serial line, paced by its baud rate.
#[derive(Debug, Clone)]
pub struct SerialLine {
    settings: SerialSettings,
    under_way: VecDeque<(Timestamp, Packet)>,
    busy_until: Timestamp,
    dropped: u64,
    faulty: Option<Box<Faulty>>,
}

impl SerialLine {
    /// A line that is idle.
    pub const fn new(settings: SerialSettings) -> Self {
        Self {
            settings,
            under_way: VecDeque::new(),
            busy_until: Timestamp::ZERO,
            dropped: 0,
            faulty: None,
        }
    }

    /// Puts a packet on the line, behind what is on it already.
    pub fn send(&mut self, now: Timestamp, packet: Packet) {
        if self.faulty.is_some() {
            return self.send_faulty(now, packet);
        }
        if self.under_way.len() >= PACKETS_MAX {
            self.dropped += 1;
            return;
        }
        self.busy_until = self.busy_until.max(now) + self.settings.time_for(packet.len());
        self.under_way.push_back((self.busy_until, packet));
    }

    /// The line is idle at `at`, and busy until `until` with what need not wait on it; false, and nothing done, where it is
    /// not idle or faulty.
    #[inline]
    pub fn passes(&mut self, at: Timestamp, until: Timestamp) -> bool {
        let is_idle = self.busy_until <= at && self.under_way.is_empty() && self.faulty.is_none();
        if is_idle {
            self.busy_until = until;
        }
        is_idle
    }

    /// How long so many bytes take.
    pub fn time_for(&self, bytes: usize) -> Span {
        self.settings.time_for(bytes)
    }

    /// When the next packet is through.
    pub fn next_arrival(&self) -> Timestamp {
        self.under_way.front().map_or(Timestamp::MAX, |(at, _)| *at)
    }

    /// A packet that is through by `now`.
    pub fn arrived(&mut self, now: Timestamp) -> Option<Packet> {
        if self.next_arrival() > now {
            return None;
        }
        self.under_way.pop_front().map(|(_, packet)| packet)
    }

    /// Packets that found the queue full.
    pub const fn dropped(&self) -> u64 {
        self.dropped
    }
}

#[cfg(test)]
mod tests {
    use super::{PACKETS_MAX, Packet, SerialLine, SerialSettings, Span, Timestamp};

    #[test]
    fn bytes_take_their_time_one_after_another() {
        let mut line = SerialLine::new(SerialSettings::new_8n1(9_600));
        let packet = Packet::from_slice(&[0; 12]).unwrap();
        line.send(Timestamp::ZERO, packet);
        line.send(Timestamp::ZERO, packet);
        let once = Timestamp::ZERO + Span::from_micros(12_500);
        assert_eq!(line.next_arrival(), once);
        assert!(line.arrived(once - Span::from_nanos(1)).is_none());
        assert!(line.arrived(once).is_some());
        assert_eq!(line.next_arrival(), once + Span::from_micros(12_500));
    }

    #[test]
    fn what_finds_no_room_is_counted() {
        let mut line = SerialLine::new(SerialSettings::new_8n1(9_600));
        for _ in 0..PACKETS_MAX + 3 {
            line.send(Timestamp::ZERO, Packet::from_slice(b"x").unwrap());
        }
        assert_eq!(line.dropped(), 3);
    }
}
