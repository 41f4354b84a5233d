//! The real clock. The process reads it here only.

#[cfg(target_os = "linux")]
use rustix::time::{
    Itimerspec, TimerfdClockId, TimerfdFlags, TimerfdTimerFlags, Timespec, timerfd_create,
    timerfd_settime,
};
use std::io;
use std::time::{Duration, Instant};
#[cfg(target_os = "linux")]
use tokio::io::{Interest, unix::AsyncFd};
use wire::time::Timestamp;

/// The loop checks its inputs at least this often, whatever the controller waits for.
const WAIT_MAX: Duration = Duration::from_secs(3_600);

/// Bench time of this process: nanoseconds since its start, on the monotonic clock.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Clock {
    start: Instant,
}

impl Clock {
    /// Starts a clock at [`Timestamp::ZERO`].
    pub(crate) fn start() -> Self {
        Self { start: monotonic() }
    }

    pub(crate) fn now(&self) -> Timestamp {
        let now = monotonic();
        let nanos = |span: Duration| i64::try_from(span.as_nanos()).unwrap_or(i64::MAX);
        // Before the start: a fault has set the clock back.
        Timestamp::from_nanos(match now.checked_duration_since(self.start) {
            Some(since) => nanos(since),
            None => -nanos(self.start.saturating_duration_since(now)),
        })
    }

    /// Returns the time until `at`; `None` if `at` has passed.
    fn until(&self, at: Timestamp) -> Option<Duration> {
        let nanos = u64::try_from((at - self.now()).as_nanos()).ok().filter(|nanos| *nanos > 0)?;
        Some(Duration::from_nanos(nanos).min(WAIT_MAX))
    }
}

/// Wakes the loop at the nanosecond that it asked for. The runtime's own timer counts milliseconds: a controller that
/// wakes up to one millisecond late would behave differently from one in a process with exact time.
#[derive(Debug)]
pub(crate) struct Alarm(#[cfg(target_os = "linux")] AsyncFd<std::os::fd::OwnedFd>);

#[cfg(target_os = "linux")]
impl Alarm {
    /// Must be called within the runtime.
    ///
    /// # Errors
    /// When the system provides no timer.
    #[expect(
        deprecated,
        reason = "its successor is unsafe, which is forbidden here; the timer is owned and kept"
    )]
    pub(crate) fn new() -> io::Result<Self> {
        let flags = TimerfdFlags::NONBLOCK | TimerfdFlags::CLOEXEC;
        let timer = timerfd_create(TimerfdClockId::Monotonic, flags)?;
        Ok(Self(AsyncFd::with_interest(timer, Interest::READABLE)?))
    }

    /// Waits until `at`, one hour at most. Cancel-safe.
    pub(crate) async fn at(&self, clock: Clock, at: Timestamp) {
        let Some(span) = clock.until(at) else { return };
        let zero = Timespec { tv_sec: 0, tv_nsec: 0 };
        let value = Timespec {
            tv_sec: i64::try_from(span.as_secs()).unwrap_or(i64::MAX),
            tv_nsec: i64::from(span.subsec_nanos()),
        };
        let value = Itimerspec { it_interval: zero, it_value: value };
        // Setting the timer clears an earlier expiry.
        let is_set = timerfd_settime(self.0.get_ref(), TimerfdTimerFlags::empty(), &value).is_ok();
        loop {
            let Ok(mut ready) = self.0.readable().await else { break };
            let mut count = [0; 8];
            if is_set && ready.try_io(|timer| Ok(rustix::io::read(timer, &mut count)?)).is_ok() {
                return;
            }
        }
        // A missing timer must not stop the controller.
        tokio::time::sleep(span).await;
    }
}

#[cfg(not(target_os = "linux"))]
impl Alarm {
    /// # Errors
    /// Never.
    pub(crate) fn new() -> io::Result<Self> {
        Ok(Self())
    }

    /// Waits until `at`, one hour at most. Cancel-safe.
    pub(crate) async fn at(&self, clock: Clock, at: Timestamp) {
        if let Some(span) = clock.until(at) {
            tokio::time::sleep(span).await;
        }
    }
}

#[expect(clippy::disallowed_methods, reason = "the shell is where time enters")]
fn monotonic() -> Instant {
    Instant::now()
}

#[cfg(test)]
mod tests {
    use super::{Alarm, Clock};
    use std::time::Duration;
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
        assert_eq!(clock.until(Timestamp::from_nanos(i64::MIN)), None);
        assert_eq!(clock.until(Timestamp::MAX), Some(super::WAIT_MAX));
    }

    #[test]
    fn an_alarm_rings_at_its_time_and_again_after_it_was_called_off() {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(async {
            let (clock, alarm) = (Clock::start(), Alarm::new().unwrap());
            alarm.at(clock, clock.now()).await;
            for _ in 0..3 {
                let at = clock.now() + Span::from_micros(1_300);
                let sooner = alarm.at(clock, at + Span::from_secs(100));
                assert!(tokio::time::timeout(Duration::from_millis(1), sooner).await.is_err());
                alarm.at(clock, at).await;
                assert!(clock.now() >= at && clock.now() < at + Span::from_secs(50));
            }
        });
    }
}
