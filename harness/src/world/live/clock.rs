//! The real clock of a run; the only one that the live world reads.

use std::time::Duration;
use tokio::time::Instant;
use wire::time::Timestamp;

/// Bench time: zero when the run began.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Clock {
    began: Instant,
}

impl Clock {
    #[expect(clippy::disallowed_methods, reason = "the live world is where the real clock is read")]
    pub(crate) fn start() -> Self {
        Self { began: Instant::now() }
    }

    pub(crate) fn now(&self) -> Timestamp {
        let nanos = self.began.elapsed().as_nanos();
        Timestamp::from_nanos(i64::try_from(nanos).unwrap_or(i64::MAX))
    }

    pub(crate) async fn sleep_until(&self, at: Timestamp) {
        let nanos = u64::try_from(at.as_nanos()).unwrap_or(0);
        tokio::time::sleep_until(self.began + Duration::from_nanos(nanos)).await;
    }
}
