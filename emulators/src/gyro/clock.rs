//! The gyro's own clock: the times of its outputs.

use libm::round;
use wire::time::{Span, Timestamp};

const SECONDS_PER_NANO: f64 = 1e-9;

/// A period is counted in 2^-24 ns, which is exact to within 3e-14 of the shortest one, 1 ms.
const FRACTION_BITS: u32 = 24;
const PARTS_PER_NANO: f64 = (1u64 << FRACTION_BITS) as f64;
const FRACTION: i64 = (1 << FRACTION_BITS) - 1;

/// Output times, evenly spaced by a period that need not be whole nanoseconds. The fraction is carried over, so that
/// rounding errors never accumulate.
#[derive(Debug, Clone, Copy)]
pub(super) struct OutputClock {
    next: Timestamp,
    /// Time since the previous output.
    interval_s: f64,
    /// Fraction that the next output time omits, and the period, in parts of a nanosecond.
    fraction: i64,
    period: i64,
}

impl OutputClock {
    /// A clock whose first output is the start of the run, at `rate` times its nominal rate.
    pub(super) fn new(nominal: Span, rate: f64) -> Self {
        let mut clock = Self { next: Timestamp::ZERO, interval_s: 0.0, fraction: 0, period: 0 };
        clock.set_rate(nominal, rate);
        clock
    }

    /// Sets the next output to one period after `now`.
    pub(super) fn start(&mut self, now: Timestamp) {
        self.next = now;
        self.fraction = 0;
        self.tick();
    }

    /// Sets the rate to `rate` times the nominal one, from the next output on.
    pub(super) fn set_rate(&mut self, nominal: Span, rate: f64) {
        self.period = round(nominal.as_nanos() as f64 / rate * PARTS_PER_NANO) as i64;
    }

    /// Time of the next output.
    pub(super) const fn next(&self) -> Timestamp {
        self.next
    }

    /// The time from the last output to the next, in seconds.
    #[inline]
    pub(super) const fn interval_s(&self) -> f64 {
        self.interval_s
    }

    /// The time between two outputs at the current rate, in seconds.
    pub(super) fn period_s(&self) -> f64 {
        self.period as f64 / PARTS_PER_NANO * SECONDS_PER_NANO
    }

    #[inline]
    pub(super) fn tick(&mut self) {
        // No overflow: the clock's error is bounded, and the period is at most twice the nominal one.
        let due = self.period + self.fraction;
        let whole_ns = due >> FRACTION_BITS;
        self.fraction = due & FRACTION;
        self.interval_s = whole_ns as f64 * SECONDS_PER_NANO;
        self.next += Span::from_nanos(whole_ns);
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

    #[test]
    fn the_interval_is_the_one_between_two_instants() {
        let mut clock = OutputClock::new(Span::from_millis(1), 1.000_7);
        clock.start(Timestamp::from_nanos(123));
        for _ in 0..1_000 {
            let last = clock.next();
            clock.tick();
            let interval = clock.next() - last;
            assert!((clock.interval_s() - interval.as_secs_f64()).abs() < 1e-18);
            assert!((clock.period_s() - interval.as_secs_f64()).abs() < 1e-9);
        }
    }
}
