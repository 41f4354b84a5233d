//! When attempts to reopen a lost port are made, and their limit.

use std::pin::Pin;
use std::time::Duration;
use tokio::time::Sleep;

/// Time between two attempts: a device is heard at most this long after it is back. Assumption: short beside the start of a
/// device, and long beside an attempt, which takes a millisecond where it looks for a USB id.
const EVERY: Duration = Duration::from_millis(50);
/// A port that stays away for longer is given up. Assumption: time to plug it in again.
pub(super) const TOTAL_MAX: Duration = Duration::from_secs(60);

/// A bounded series of attempts.
#[derive(Debug, Default)]
pub(super) struct Attempts {
    waited: Duration,
    /// The current delay; kept here so that a cancelled wait continues where it was.
    sleep: Option<Pin<Box<Sleep>>>,
}

impl Attempts {
    /// Opens a port anew, as often as it takes, or until it is time to give up: then returns the last error. The next
    /// call waits as long again. May be cancelled.
    pub(super) async fn reopen<T, E>(
        &mut self,
        open: impl Fn() -> Result<T, E>,
    ) -> Result<T, Option<E>> {
        let mut last = None;
        while self.pause().await {
            match open() {
                Ok(opened) => {
                    *self = Self::default();
                    return Ok(opened);
                }
                Err(error) => last = Some(error),
            }
        }
        *self = Self::default();
        Err(last)
    }

    /// Waits for the next attempt; `false` when it is time to give up. May be cancelled.
    async fn pause(&mut self) -> bool {
        if self.waited >= TOTAL_MAX {
            return false;
        }
        let sleep = self.sleep.get_or_insert_with(|| Box::pin(tokio::time::sleep(EVERY)));
        sleep.as_mut().await;
        self.sleep = None;
        self.waited += EVERY;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::{Attempts, EVERY, TOTAL_MAX};

    fn in_time<T>(work: impl Future<Output = T>) -> T {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap();
        runtime.block_on(work)
    }

    #[test]
    fn attempts_end() {
        in_time(async {
            let mut attempts = Attempts { waited: TOTAL_MAX - EVERY, sleep: None };
            assert!(attempts.pause().await);
            assert!(!attempts.pause().await);
        });
    }

    #[test]
    fn a_pause_that_is_called_off_again_and_again_ends() {
        in_time(async {
            let (mut attempts, mut looks) = (Attempts::default(), 0);
            while tokio::time::timeout(EVERY / 10, attempts.pause()).await.is_err() {
                looks += 1;
                assert!(looks < 1_000, "it begins anew each time");
            }
            assert!(looks > 1);
        });
    }
}
