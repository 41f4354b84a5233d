//! The real clock of a run; the only one that the live world reads.

use rustix::thread::{Timespec, nanosleep};
use std::time::Duration;
use tokio::time::Instant;
use wire::time::{Span, Timestamp};

/// The most that a thread turns on the spot to be on time: what the system may take to wake it. Assumption: a
/// machine that is not overloaded does within this; at 1,000 waits a second it costs a tenth of a processor.
pub const SPIN_MAX: Span = Span::from_micros(100);
/// The longest single sleep of a thread; a longer one is several.
const SLEEP_NS_MAX: i64 = 999_999_999;

/// Bench time: zero when the run began.
#[derive(Debug, Clone, Copy)]
pub struct Clock {
    began: Instant,
}

impl Clock {
    /// From now on.
    #[expect(clippy::disallowed_methods, reason = "the live world is where the real clock is read")]
    pub fn start() -> Self {
        Self { began: Instant::now() }
    }

    /// Bench time.
    pub fn now(&self) -> Timestamp {
        let nanos = self.began.elapsed().as_nanos();
        Timestamp::from_nanos(i64::try_from(nanos).unwrap_or(i64::MAX))
    }

    /// Waits until then.
    pub async fn sleep_until(&self, at: Timestamp) {
        let nanos = u64::try_from(at.as_nanos()).unwrap_or(0);
        tokio::time::sleep_until(self.began + Duration::from_nanos(nanos)).await;
    }

    /// Holds the thread until `at`, to about a microsecond where the system wakes it within [`SPIN_MAX`].
    /// For the last bit of a wait: nothing else runs on this thread meanwhile.
    pub fn hold_until(&self, at: Timestamp) {
        loop {
            let sleep = (at - self.now() - SPIN_MAX).as_nanos();
            if sleep <= 0 {
                break;
            }
            // Woken by a signal it sleeps on.
            let _ = nanosleep(&Timespec { tv_sec: 0, tv_nsec: sleep.min(SLEEP_NS_MAX) });
        }
        while self.now() < at {
            std::hint::spin_loop();
        }
    }
}
