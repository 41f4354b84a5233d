//! One direction of a serial line: bytes arrive when their last stop bit has passed. Faults are optional.

mod collision;
mod faulty;
mod uart;

pub use collision::collide;
use faulty::Faulty;
use std::collections::VecDeque;
use wire::packet::Packet;
use wire::serial::SerialSettings;
use wire::time::{Span, Timestamp};

/// Most packets that wait for the line unless [more are expected](SerialLine::expect); those beyond are dropped and counted.
const PACKETS_MAX: usize = 256;
/// The same where a real line paces them: a driver's buffer may come at once.
const PACKETS_AT_ONCE_MAX: usize = 65_536;

/// One direction of a serial line, paced by its baud rate.
#[derive(Debug, Clone)]
pub struct SerialLine {
    settings: SerialSettings,
    /// A real line takes the time.
    is_real: bool,
    under_way: VecDeque<(Timestamp, Packet)>,
    busy_until: Timestamp,
    expected: usize,
    dropped: u64,
    faulty: Option<Box<Faulty>>,
}

impl SerialLine {
    /// An idle line.
    pub const fn new(settings: SerialSettings) -> Self {
        Self {
            settings,
            is_real: false,
            under_way: VecDeque::new(),
            busy_until: Timestamp::ZERO,
            expected: 0,
            dropped: 0,
            faulty: None,
        }
    }

    /// An idle line of the same settings.
    pub const fn another(&self) -> Self {
        Self::new(self.settings)
    }

    /// Packets take no time from now on, because they take it on a real line.
    pub const fn leave_time_to_a_real_line(&mut self) {
        self.is_real = true;
    }

    /// So many packets more may wait at once.
    pub const fn expect(&mut self, packets: usize) {
        self.expected += packets;
    }

    fn is_full(&self) -> bool {
        let most = if self.is_real { PACKETS_AT_ONCE_MAX } else { PACKETS_MAX };
        self.under_way.len() >= self.expected.max(most)
    }

    pub fn send(&mut self, now: Timestamp, packet: Packet) {
        if self.faulty.is_some() {
            return self.send_faulty(now, packet);
        }
        let until = self.busy_until.max(now) + self.time_for(packet.len());
        if self.queue(until, packet) {
            self.busy_until = until;
        }
    }

    /// A packet arrives at that time, but not before those that were sent earlier. Returns `false` if it is dropped for lack of
    /// room.
    fn queue(&mut self, at: Timestamp, packet: Packet) -> bool {
        if self.is_full() {
            self.dropped += 1;
            return false;
        }
        let at = self.under_way.back().map_or(at, |(before, _)| at.max(*before));
        self.under_way.push_back((at, packet));
        true
    }

    /// Marks the line busy from `at` until `until`, if it is idle at `at`. Returns `false`, with nothing done, if it is
    /// busy or faulty.
    #[inline]
    pub fn passes(&mut self, at: Timestamp, until: Timestamp) -> bool {
        let is_idle = self.busy_until <= at && self.under_way.is_empty() && self.faulty.is_none();
        if is_idle {
            self.busy_until = until;
        }
        is_idle
    }

    /// Time that this number of bytes takes here.
    pub fn time_for(&self, bytes: usize) -> Span {
        if self.is_real { Span::ZERO } else { self.settings.time_for(bytes) }
    }

    pub fn next_arrival(&self) -> Timestamp {
        self.under_way.front().map_or(Timestamp::MAX, |(at, _)| *at)
    }

    pub fn arrived(&mut self, now: Timestamp) -> Option<Packet> {
        if self.next_arrival() > now {
            return None;
        }
        self.under_way.pop_front().map(|(_, packet)| packet)
    }

    /// Packets dropped because the queue was full.
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
    fn what_a_real_line_has_paced_arrives_at_once() {
        let mut line = SerialLine::new(SerialSettings::new_8n1(9_600));
        line.leave_time_to_a_real_line();
        let packet = Packet::from_slice(&[0; 12]).unwrap();
        let now = Timestamp::ZERO + Span::from_millis(5);
        for _ in 0..PACKETS_MAX + 3 {
            line.send(now, packet);
        }
        assert_eq!((line.next_arrival(), line.dropped()), (now, 0));
        assert_eq!(std::iter::from_fn(|| line.arrived(now)).count(), PACKETS_MAX + 3);
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
