//! The gyro's own clock: when its outputs fall due.

use wire::time::{Span, Timestamp};

const NANOS_PER_SECOND: f64 = 1e9;

/// Instants of output, evenly spaced by a period that need not be whole nanoseconds. The fraction is
/// carried on, so that rounding never builds up.
#[derive(Debug, Clone, Copy)]
pub(super) struct OutputClock {
    next: Timestamp,
    fraction_ns: f64,
    period_ns: f64,
}

impl OutputClock {
    /// A clock whose first instant is the start of the run, at `rate` times its nominal rate.
    pub(super) fn new(nominal: Span, rate: f64) -> Self {
        let mut clock = Self { next: Timestamp::ZERO, fraction_ns: 0.0, period_ns: 0.0 };
        clock.set_rate(nominal, rate);
        clock
    }

    /// The next instant is a period after `now`.
    pub(super) fn start(&mut self, now: Timestamp) {
        self.next = now;
        self.fraction_ns = 0.0;
        self.tick();
    }

    /// From the next instant on, run at `rate` times the nominal rate.
    pub(super) fn set_rate(&mut self, nominal: Span, rate: f64) {
        self.period_ns = nominal.as_nanos() as f64 / rate;
    }

    /// The next instant of output.
    pub(super) const fn next(&self) -> Timestamp {
        self.next
    }

    /// The time between two outputs, in seconds.
    pub(super) fn period_s(&self) -> f64 {
        self.period_ns / NANOS_PER_SECOND
    }

    /// Goes on to the output after the next.
    #[inline]
    pub(super) fn tick(&mut self) {
        let due = self.period_ns + self.fraction_ns;
        let whole = due as i64;
        self.fraction_ns = due - whole as f64;
        self.next += Span::from_nanos(whole);
    }
}

#[cfg(test)]
mod tests {
    use super::OutputClock;
    use wire::time::{Span, Timestamp};

    #[test]
    fn a_fast_clock_gives_more_outputs_a_second() {
        let mut clock = OutputClock::new(Span::from_millis(10), 1.02);
        for _ in 0..102 * 3600 {
            clock.tick();
        }
        let off = clock.next() - Timestamp::from_secs_f64(3600.0);
        assert!(off.as_nanos().abs() <= 1, "{off:?}");
    }
}
