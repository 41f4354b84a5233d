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

    /// Waits until then, or up to a millisecond longer: the runtime's timers go by whole ones. An [`Alarm`] does not.
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

/// Wakes a task at a moment, to what the kernel needs for it.
#[derive(Debug)]
pub struct Alarm {
    clock: Clock,
    timer: AsyncFd<OwnedFd>,
}

/// The longest that an alarm is set for; a later moment is several. The kernel takes any, a hundred years are none.
const ALARM_MAX: Span = Span::from_secs(3_600);

impl Alarm {
    /// By this clock.
    ///
    /// # Errors
    ///
    /// When the kernel gives no timer, such as to a process with too many open files.
    pub fn new(clock: Clock) -> io::Result<Self> {
        let flags = TimerfdFlags::NONBLOCK | TimerfdFlags::CLOEXEC;
        let timer = timerfd_create(TimerfdClockId::Monotonic, flags)?;
        Ok(Self { clock, timer: ports::watch(timer, Interest::READABLE)? })
    }

    /// Waits until then, and not at all where that is over. Who stops waiting loses nothing.
    ///
    /// # Errors
    ///
    /// When the kernel takes the timer away.
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
            // Setting it takes away what it had to say of an earlier moment.
            let mut rung = self.timer.readable().await?;
            let _ = rung.try_io(|timer| Ok(rustix::io::read(timer, &mut [0_u8; 8])?));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Alarm, Clock};
    use wire::time::Span;

    /// Never before, after another one that was given up, and not by whole milliseconds.
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
        // By whole milliseconds half of them would be late by half a millisecond, on the idlest machine.
        assert!(late[5] < Span::from_micros(400), "{late:?}");
    }
}
