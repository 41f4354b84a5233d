//! When the bytes that a program writes to a serial port leave it: one after another, at the rate of the line.

use crate::link::Unsent;
use wire::packet::BYTES_MAX;
use wire::serial::SerialSettings;
use wire::time::{Span, Timestamp};

#[derive(Debug)]
pub(crate) struct Pace {
    /// Without a line of a rate, bytes leave at once.
    line: Option<SerialSettings>,
    busy_until: Timestamp,
}

impl Pace {
    pub(crate) fn of(line: Option<SerialSettings>) -> Self {
        Self { line: line.filter(|line| line.baud > 0), busy_until: Timestamp::ZERO }
    }

    /// So many bytes are written at once. They are counted in packets, as the line of a rig does it.
    pub(crate) fn send(&mut self, now: Timestamp, bytes: usize) {
        let Some(line) = self.line else { return };
        let (whole, rest) = (bytes / BYTES_MAX, bytes % BYTES_MAX);
        let packets = line.time_for(BYTES_MAX) * whole as i64;
        self.busy_until = self.busy_until.max(now) + packets + line.time_for(rest);
    }

    /// What has not left by `now`. A byte that has left in part counts as a whole one.
    pub(crate) fn unsent(&self, now: Timestamp) -> Unsent {
        let left = (self.busy_until - now).max(Span::ZERO);
        let bytes = self.line.map_or(0, |line| {
            let byte = i128::from(line.bits_per_byte()) * 1_000_000_000;
            let bits = i128::from(left.as_nanos()) * i128::from(line.baud);
            u32::try_from((bits + byte - 1) / byte).unwrap_or(u32::MAX)
        });
        Unsent { until: self.busy_until.as_nanos(), bytes }
    }
}

#[cfg(test)]
mod tests {
    use super::{Pace, SerialSettings, Timestamp, Unsent};
    use wire::time::Span;

    fn at(micros: i64) -> Timestamp {
        Timestamp::ZERO + Span::from_micros(micros)
    }

    #[test]
    fn bytes_leave_one_after_another() {
        let mut pace = Pace::of(Some(SerialSettings::new_8n1(10_000)));
        assert_eq!(pace.unsent(at(5)), Unsent { until: 0, bytes: 0 });
        pace.send(at(1_000), 3);
        pace.send(at(1_500), 65);
        assert_eq!(pace.unsent(at(1_500)), Unsent { until: 69_000_000, bytes: 68 });
        assert_eq!(pace.unsent(at(67_999)).bytes, 2);
        assert_eq!(pace.unsent(at(68_000)).bytes, 1);
        assert_eq!(pace.unsent(at(69_000)).bytes, 0);
    }

    #[test]
    fn without_a_rate_they_leave_at_once() {
        for line in [None, Some(SerialSettings::new_8n1(0))] {
            let mut pace = Pace::of(line);
            pace.send(at(0), 1_000);
            assert_eq!(pace.unsent(at(0)), Unsent { until: 0, bytes: 0 });
        }
    }
}
