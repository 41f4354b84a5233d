//! Detects lost samples that sequence numbers do not show.
//!
//! After a delayed sample the following ones are less late; after a lost one all are late, by one period each. So lost
//! samples raise the smallest delay of a window by whole periods: in a stream without sequence numbers, or when a gyro
//! restarts and continues its count.

use wire::time::{Span, Timestamp};

/// Samples in a window: two tenths of a second of a 100 Hz stream. Assumption: no host delays all of that many.
const SAMPLES: u32 = 20;

/// Compares the smallest delays of consecutive windows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LossWatch {
    period: Span,
    /// Arrival of the first sample, and the number of samples due since then.
    first: Option<(Timestamp, i64)>,
    /// Smallest delay of the previous window.
    before: Option<Span>,
    least: Span,
    samples: u32,
}

impl LossWatch {
    pub(crate) const fn new(period: Span) -> Self {
        Self { period, first: None, before: None, least: Span::MAX, samples: 0 }
    }

    /// Restarts after a gap of unknown content.
    pub(crate) const fn restart(&mut self) {
        *self = Self::new(self.period);
    }

    /// Takes a sample that arrived after `lost` known losses. Returns true if more are missing.
    pub(crate) fn sample(&mut self, now: Timestamp, lost: u16) -> bool {
        let Some((since, due)) = &mut self.first else {
            self.first = Some((now, 0));
            return false;
        };
        *due += 1 + i64::from(lost);
        let late = (now - *since) - self.period * *due;
        self.least = self.least.min(late);
        self.samples += 1;
        if self.samples < SAMPLES {
            return false;
        }
        let rose = self.before.map(|before| self.least - before);
        self.before = Some(self.least);
        (self.least, self.samples) = (Span::MAX, 0);
        // One and a half: clocks that differ by the 3 % between units add six tenths of a period per window.
        rose.is_some_and(|rose| rose > self.period * 3 / 2)
    }
}

#[cfg(test)]
mod tests {
    use super::{LossWatch, Span, Timestamp};
    use proptest::prelude::*;

    const PERIOD: Span = Span::from_millis(10);

    /// True if the watch reports a loss. `arrivals`: the due time of each sample in periods, and its delay in ms.
    fn misses(arrivals: impl IntoIterator<Item = (i64, i64)>, clock: f64) -> bool {
        let mut watch = LossWatch::new(PERIOD);
        let mut now = Timestamp::ZERO;
        arrivals.into_iter().fold(false, |missed, (number, late_ms)| {
            let due_s = number as f64 * 0.010 * clock;
            // In order, as on a line.
            now = now.max(Timestamp::from_secs_f64(due_s) + Span::from_millis(late_ms));
            missed | watch.sample(now, 0)
        })
    }

    #[test]
    fn two_samples_that_nobody_counted_are_missed() {
        let gap = |lost| (0..200).map(move |n| (if n < 77 { n } else { n + lost }, 0));
        assert!(misses(gap(2), 1.0) && misses(gap(9), 1.0));
        assert!(!misses(gap(0), 1.0));
    }

    #[test]
    fn a_clock_that_is_off_misses_none() {
        for clock in [0.97, 1.03] {
            assert!(!misses((0..2_000).map(|n| (n, 0)), clock));
        }
    }

    proptest! {
        /// Stalls of up to 100 ms, after which everything comes at once.
        #[test]
        fn what_is_late_is_not_lost(stalls in prop::collection::vec((0i64..1_000, 0i64..100), 0..8)) {
            let late = |n: i64| {
                let held = |(at, ms): &(i64, i64)| (at * 10 + ms - n * 10).clamp(0, *ms);
                stalls.iter().filter(|(at, _)| n >= *at).map(held).max().unwrap_or(0)
            };
            prop_assert!(!misses((0..1_100).map(|n| (n, late(n))), 1.0));
        }
    }
}
