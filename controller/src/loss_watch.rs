//! Detects samples that were lost or came twice and that sequence numbers do not show.
//!
//! After a delayed sample the following ones are less late; after a lost one all are late, by one period each, and after one
//! that came twice all are early. So both move the smallest delay of a window by whole periods, and it stays there: in a stream
//! without sequence numbers, or when a gyro restarts and continues its count.

use wire::time::{Span, Timestamp};

/// Samples in a window: two tenths of a second of a 100 Hz stream. Assumption: no host delays all of that many, twice in a row.
const SAMPLES: u32 = 20;
/// Change from which a sample is lost or came twice, in periods, if the ratio of the clocks is known.
const CHANGE: f64 = 0.75;
/// The same while it is not: clocks that differ by the 3 % between units add six tenths of a period in a window.
const CHANGE_AT_FIRST: f64 = 1.5;

/// Compares the smallest delays of consecutive windows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LossWatch {
    period: Span,
    /// A period by the host's clock, and the change from which a sample is lost or came twice, in periods.
    step: Span,
    change: f64,
    /// When the last sample was due, by the first one.
    due: Option<Timestamp>,
    /// Smallest delay so far, and whether a second window has confirmed it: what waited before the first sample comes early.
    before: Option<(Span, bool)>,
    /// Whether the window before left it.
    left: bool,
    least: Span,
    samples: u32,
}

impl LossWatch {
    pub(crate) const fn new(period: Span) -> Self {
        Self {
            period,
            step: period,
            change: CHANGE_AT_FIRST,
            due: None,
            before: None,
            left: false,
            least: Span::MAX,
            samples: 0,
        }
    }

    /// Restarts after a gap of unknown content.
    pub(crate) const fn restart(&mut self) {
        *self = Self { step: self.step, change: self.change, ..Self::new(self.period) };
    }

    /// From now on the gyro's clock is known to run at `ratio` of the host's.
    pub(crate) fn compared(&mut self, ratio: f64) {
        self.step = Span::from_secs_f64(self.period.as_secs_f64() / ratio);
        self.change = CHANGE;
    }

    /// Takes a sample that arrived after `lost` known losses. Returns true if more are missing, or some came twice.
    pub(crate) fn sample(&mut self, now: Timestamp, lost: u16) -> bool {
        let Some(due) = &mut self.due else {
            self.due = Some(now);
            return false;
        };
        *due += self.step * (1 + i64::from(lost));
        self.least = self.least.min(now - *due);
        self.samples += 1;
        if self.samples < SAMPLES {
            return false;
        }
        let least = core::mem::replace(&mut self.least, Span::MAX);
        self.samples = 0;
        let Some((before, is_sure)) = self.before else {
            self.before = Some((least, false));
            return false;
        };
        let periods = (least - before).as_secs_f64() / self.period.as_secs_f64();
        if periods.abs() <= self.change {
            (self.before, self.left) = (Some((least, true)), false);
            return false;
        }
        if !self.left {
            // One window alone may have been held up.
            self.left = true;
            return false;
        }
        (self.before, self.left) = (Some((least, is_sure)), false);
        is_sure
    }
}

#[cfg(test)]
mod tests {
    use super::{LossWatch, Span, Timestamp};
    use proptest::prelude::*;

    const PERIOD: Span = Span::from_millis(10);

    /// True if the watch reports a loss. `arrivals`: the due time of each sample in periods, and its delay in ms.
    fn misses(arrivals: impl IntoIterator<Item = (i64, i64)>, clock: f64, is_known: bool) -> bool {
        let mut watch = LossWatch::new(PERIOD);
        let mut now = Timestamp::ZERO;
        if is_known {
            watch.compared(1.0 / clock);
        }
        arrivals.into_iter().fold(false, |missed, (number, late_ms)| {
            let due_s = number as f64 * 0.010 * clock;
            // In order, as on a line.
            now = now.max(Timestamp::from_secs_f64(due_s) + Span::from_millis(late_ms));
            missed | watch.sample(now, 0)
        })
    }

    #[test]
    fn samples_that_nobody_counted_are_missed() {
        let gap = |lost| (0..200).map(move |n| (if n < 77 { n } else { n + lost }, 0));
        assert!(misses(gap(2), 1.0, false) && misses(gap(9), 1.0, false));
        assert!(!misses(gap(0), 1.0, false) && !misses(gap(1), 1.0, false));
        for clock in [0.97, 1.0, 1.03] {
            assert!(misses(gap(1), clock, true) && misses(gap(9), clock, true), "{clock}");
        }
    }

    /// A turn at 30 deg/s went on by 0.3 deg for each.
    #[test]
    fn a_sample_that_comes_twice_is_seen() {
        for clock in [0.97, 1.0, 1.03] {
            let twice =
                (0..300).flat_map(|n| [(n, 0); 2].into_iter().take(1 + usize::from(n == 77)));
            assert!(misses(twice, clock, true), "{clock}");
        }
    }

    /// A port that was opened while samples waited hands them over at once.
    #[test]
    fn what_waited_before_the_first_one_did_not_come_twice() {
        let early = |n: i64| (n, (700 - n * 10).max(0));
        assert!(!misses((0..400).map(early), 1.0, true));
    }

    #[test]
    fn a_clock_that_is_off_misses_none() {
        for clock in [0.97, 1.03] {
            for is_known in [false, true] {
                assert!(!misses((0..2_000).map(|n| (n, 0)), clock, is_known));
            }
        }
        // A clock that changes with the temperature after it was compared.
        let slower = (0..2_000).map(|n| (n, n / 100 * 2));
        assert!(!misses(slower, 1.0, true));
    }

    proptest! {
        /// Stalls of up to 100 ms, after which everything comes at once.
        #[test]
        fn what_is_late_is_not_lost(stalls in prop::collection::vec((0i64..1_000, 0i64..100), 0..8)) {
            let late = |n: i64| {
                let held = |(at, ms): &(i64, i64)| (at * 10 + ms - n * 10).clamp(0, *ms);
                stalls.iter().filter(|(at, _)| n >= *at).map(held).max().unwrap_or(0)
            };
            prop_assert!(!misses((0..1_100).map(|n| (n, late(n))), 1.0, true));
        }
    }
}
