//! How long to wait before a vanished port is tried again, and when to stop trying.

use std::time::Duration;
use wire::time::Span;

/// First wait. Assumption: a USB adapter that was reset is back after a few of these.
const DELAY_MIN: Duration = Duration::from_millis(100);
/// Longest wait.
const DELAY_MAX: Duration = Duration::from_secs(2);
/// A port that stays away for this long is given up. Assumption: time to plug it in again.
const TOTAL_MAX: Duration = Duration::from_secs(60);
/// A link that lived for this long ends the series; one that did not has only flickered.
const LIFE_MIN: Span = Span::from_secs(2);

/// A bounded series of growing delays.
#[derive(Debug, Default)]
pub(super) struct Backoff {
    last: Option<Duration>,
    total: Duration,
}

impl Backoff {
    /// A link that was opened has broken after `life`.
    pub(super) fn note_life(&mut self, life: Span) {
        if life >= LIFE_MIN {
            *self = Self::default();
        }
    }

    /// The next delay; `None` when it is time to give up.
    pub(super) fn next(&mut self) -> Option<Duration> {
        let delay = self.last.map_or(DELAY_MIN, |last| (last * 2).min(DELAY_MAX));
        self.total += delay;
        self.last = Some(delay);
        (self.total <= TOTAL_MAX).then_some(delay)
    }
}

#[cfg(test)]
mod tests {
    use super::{Backoff, DELAY_MAX, DELAY_MIN, LIFE_MIN, TOTAL_MAX};
    use std::time::Duration;
    use wire::time::Span;

    #[test]
    fn delays_grow_to_a_bound_and_end() {
        let mut backoff = Backoff::default();
        let delays: Vec<Duration> = std::iter::from_fn(|| backoff.next()).collect();
        assert_eq!(delays[..3], [DELAY_MIN, DELAY_MIN * 2, DELAY_MIN * 4]);
        assert_eq!(delays.last(), Some(&DELAY_MAX));
        let total: Duration = delays.iter().sum();
        assert!(total <= TOTAL_MAX && total + DELAY_MAX > TOTAL_MAX);
        assert_eq!(backoff.next(), None);
    }

    #[test]
    fn only_a_link_that_lived_starts_the_series_anew() {
        let mut backoff = Backoff::default();
        backoff.next();
        backoff.note_life(LIFE_MIN - Span::from_nanos(1));
        assert_eq!(backoff.next(), Some(DELAY_MIN * 2));
        backoff.note_life(LIFE_MIN);
        assert_eq!(backoff.next(), Some(DELAY_MIN));
    }
}
