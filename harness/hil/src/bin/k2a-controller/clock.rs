//! The real clock, read in one place.

use std::time::{Duration, Instant};
use wire::time::Timestamp;

/// The loop looks at its inputs at least this often, whatever the controller is waiting for.
const WAIT_MAX: Duration = Duration::from_secs(3_600);

/// Bench time of this process: nanoseconds since it began, on the monotonic clock.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Clock {
    start: Instant,
}

impl Clock {
    /// A clock that stands at [`Timestamp::ZERO`].
    pub(crate) fn start() -> Self {
        Self { start: monotonic() }
    }

    /// What time it is.
    pub(crate) fn now(&self) -> Timestamp {
        let nanos = monotonic().saturating_duration_since(self.start).as_nanos();
        Timestamp::from_nanos(i64::try_from(nanos).unwrap_or(i64::MAX))
    }

    /// When `at` will be, as the runtime's timer wants it.
    #[expect(clippy::disallowed_methods, reason = "the shell is where time enters")]
    pub(crate) fn instant(&self, at: Timestamp) -> tokio::time::Instant {
        let now = self.now();
        let nanos = (at - now).as_nanos().max(0).unsigned_abs();
        tokio::time::Instant::now() + Duration::from_nanos(nanos).min(WAIT_MAX)
    }
}

#[expect(clippy::disallowed_methods, reason = "the shell is where time enters")]
fn monotonic() -> Instant {
    Instant::now()
}

#[cfg(test)]
mod tests {
    use super::Clock;
    use wire::time::{Span, Timestamp};

    #[test]
    fn it_starts_at_zero_and_never_runs_back() {
        let clock = Clock::start();
        let (first, second) = (clock.now(), clock.now());
        assert!(Timestamp::ZERO <= first && first <= second);
        assert!(second < Timestamp::ZERO + Span::from_secs(60));
    }

    #[test]
    fn the_past_is_now_and_the_far_future_is_bounded() {
        let clock = Clock::start();
        let past = clock.instant(Timestamp::from_nanos(i64::MIN));
        let far = clock.instant(Timestamp::MAX);
        assert!(far > past);
        assert!(far - past <= super::WAIT_MAX * 2);
    }
}
