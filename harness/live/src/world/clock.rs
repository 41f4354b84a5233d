//! The real clock of a run; the only one that the live world reads.

use rustix::thread::{Timespec, nanosleep};
use rustix::time::{
    Itimerspec, TimerfdClockId, TimerfdFlags, TimerfdTimerFlags, timerfd_create, timerfd_settime,
};
use std::io;
use std::os::fd::OwnedFd;
use std::time::Duration;
use tokio::io::Interest;
use tokio::io::unix::AsyncFd;
use tokio::time::Instant;
use wire::time::{Span, Timestamp};

/// Longest busy wait of a thread for precise timing: the time that the system may take to wake it. Assumption: a
/// machine that is not overloaded wakes it within this; at 1,000 waits per second it costs a tenth of a processor.
pub const SPIN_MAX: Span = Span::from_micros(100);
/// Longest single sleep of a thread; a longer one is split.
const SLEEP_NS_MAX: i64 = 999_999_999;

/// Bench time: zero at the start of the run.
#[derive(Debug, Clone, Copy)]
pub struct Clock {
    began: Instant,
}

impl Clock {
    /// Starts at zero now.
    #[expect(clippy::disallowed_methods, reason = "the live world is where the real clock is read")]
    pub fn start() -> Self {
        Self { began: Instant::now() }
    }

    pub fn now(&self) -> Timestamp {
        let nanos = self.began.elapsed().as_nanos();
        Timestamp::from_nanos(i64::try_from(nanos).unwrap_or(i64::MAX))
    }

    /// Waits until `at`, or up to a millisecond longer, as the runtime's timers have that resolution; an [`Alarm`] is
    /// more precise.
    pub async fn sleep_until(&self, at: Timestamp) {
        let nanos = u64::try_from(at.as_nanos()).unwrap_or(0);
        tokio::time::sleep_until(self.began + Duration::from_nanos(nanos)).await;
    }

    /// Blocks the thread until `at`, to about a microsecond if the system wakes it within [`SPIN_MAX`]. For the last
    /// part of a wait: nothing else runs on this thread meanwhile.
    pub fn hold_until(&self, at: Timestamp) {
        loop {
            let sleep = (at - self.now() - SPIN_MAX).as_nanos();
            if sleep <= 0 {
                break;
            }
            // If a signal wakes it, the loop sleeps again.
            let _ = nanosleep(&Timespec { tv_sec: 0, tv_nsec: sleep.min(SLEEP_NS_MAX) });
        }
        while self.now() < at {
            std::hint::spin_loop();
        }
    }
}

/// Wakes a task at an instant, with the precision of the kernel.
#[derive(Debug)]
pub struct Alarm {
    clock: Clock,
    timer: AsyncFd<OwnedFd>,
}

/// Longest single setting of an alarm; a later instant takes several.
const ALARM_MAX: Span = Span::from_secs(3_600);

impl Alarm {
    /// Creates an alarm by this clock.
    ///
    /// # Errors
    /// When the kernel has no timer, for example for a process with too many open files.
    pub fn new(clock: Clock) -> io::Result<Self> {
        let flags = TimerfdFlags::NONBLOCK | TimerfdFlags::CLOEXEC;
        let timer = timerfd_create(TimerfdClockId::Monotonic, flags)?;
        Ok(Self { clock, timer: ports::watch(timer, Interest::READABLE)? })
    }

    /// Waits until `at`; returns at once if that has passed. Cancel-safe.
    ///
    /// # Errors
    /// When the timer fails.
    pub async fn at(&self, at: Timestamp) -> io::Result<()> {
        loop {
            let left = (at - self.clock.now()).min(ALARM_MAX).as_nanos();
            if left <= 0 {
                return Ok(());
            }
            let value = Timespec { tv_sec: left / 1_000_000_000, tv_nsec: left % 1_000_000_000 };
            let once =
                Itimerspec { it_interval: Timespec { tv_sec: 0, tv_nsec: 0 }, it_value: value };
            timerfd_settime(&self.timer, TimerfdTimerFlags::empty(), &once)?;
            // Setting the timer clears its earlier expiry.
            let mut rung = self.timer.readable().await?;
            let _ = rung.try_io(|timer| Ok(rustix::io::read(timer, &mut [0_u8; 8])?));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Alarm, Clock};
    use wire::time::Span;

    /// Never early, also after a cancelled wait, and not rounded to milliseconds.
    #[tokio::test]
    async fn an_alarm_rings_when_it_is_due() {
        let clock = Clock::start();
        let alarm = Alarm::new(clock).unwrap();
        let mut late = Vec::new();
        for k in 1..=40 {
            let earlier = clock.now() + Span::from_secs(30);
            tokio::select! {
                biased;
                rung = alarm.at(earlier) => panic!("{rung:?} in 30 s"),
                () = tokio::task::yield_now() => {}
            }
            let at = clock.now() + Span::from_micros(1_100 + 37 * k);
            alarm.at(at).await.unwrap();
            let now = clock.now();
            assert!(now >= at, "{now:?} {at:?}");
            late.push(now - at);
        }
        alarm.at(clock.now() - Span::from_secs(1)).await.unwrap();
        late.sort();
        // With millisecond resolution half of them would be late by half a millisecond, even on an idle machine.
        assert!(late[5] < Span::from_micros(400), "{late:?}");
    }
}
