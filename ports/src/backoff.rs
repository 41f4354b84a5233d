//! Delays between attempts to reopen a lost port, and the limit of attempts.

use std::pin::Pin;
use std::time::Duration;
use tokio::time::Sleep;

/// First delay. Assumption: a USB adapter that was reset is back after a few of these.
const DELAY_MIN: Duration = Duration::from_millis(100);
/// Longest delay.
const DELAY_MAX: Duration = Duration::from_secs(2);
/// A port that stays away for longer is given up. Assumption: time to plug it in again.
pub(super) const TOTAL_MAX: Duration = Duration::from_secs(60);

/// A bounded series of growing delays.
#[derive(Debug, Default)]
pub(super) struct Backoff {
    last: Option<Duration>,
    total: Duration,
    /// The current delay; kept here so that a cancelled wait continues where it was.
    sleep: Option<Pin<Box<Sleep>>>,
}

impl Backoff {
    /// Waits for the next attempt; `false` when it is time to give up. May be cancelled.
    pub(super) async fn pause(&mut self) -> bool {
        if self.sleep.is_none() {
            let Some(delay) = self.next_delay() else { return false };
            self.sleep = Some(Box::pin(tokio::time::sleep(delay)));
        }
        if let Some(sleep) = &mut self.sleep {
            sleep.as_mut().await;
        }
        self.sleep = None;
        true
    }

    fn next_delay(&mut self) -> Option<Duration> {
        let delay = self.last.map_or(DELAY_MIN, |last| (last * 2).min(DELAY_MAX));
        self.total += delay;
        self.last = Some(delay);
        (self.total <= TOTAL_MAX).then_some(delay)
    }
}

#[cfg(test)]
mod tests {
    use super::{Backoff, DELAY_MAX, DELAY_MIN, TOTAL_MAX};
    use std::time::Duration;

    #[test]
    fn delays_grow_to_a_bound_and_end() {
        let mut backoff = Backoff::default();
        let delays: Vec<Duration> = std::iter::from_fn(|| backoff.next_delay()).collect();
        assert_eq!(delays[..3], [DELAY_MIN, DELAY_MIN * 2, DELAY_MIN * 4]);
        assert_eq!(delays.last(), Some(&DELAY_MAX));
        let total: Duration = delays.iter().sum();
        assert!(total <= TOTAL_MAX && total + DELAY_MAX > TOTAL_MAX);
    }

    #[test]
    fn a_pause_that_is_called_off_again_and_again_ends() {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap();
        runtime.block_on(async {
            let (mut backoff, mut looks) = (Backoff::default(), 0);
            while tokio::time::timeout(DELAY_MIN / 10, backoff.pause()).await.is_err() {
                looks += 1;
                assert!(looks < 1_000, "it begins anew each time");
            }
            assert!(looks > 1);
        });
    }
}
