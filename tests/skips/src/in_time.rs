//! Tests that need real time, on machines that may not provide it.

use crate::skip;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use std::os::fd::OwnedFd;
use std::panic::{UnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// Message of a run whose machine was late.
const NOT_IN_TIME: &str = "this machine did not keep real time";
/// Interval between two bytes that measure lateness.
const PERIOD: Duration = Duration::from_millis(5);
/// A fifth of the shortest time-out under test, 100 ms: an exchange on a line waits several times. On an idle machine a
/// thread is at most 4 ms late.
const LATE_MS_MAX: u64 = 20;

/// Runs a test that needs real time. If it fails while the machine was late, the failure proves nothing: the test is
/// skipped with a message. The same holds if its panic message states that the run did not keep real time.
pub fn in_time(test: impl FnOnce() + UnwindSafe) {
    let watch = Watch::start();
    let Err(panic) = catch_unwind(test) else { return };
    let late_ms = watch.stop();
    let said = panic.downcast_ref::<String>().map_or("", String::as_str);
    if !is_excused(late_ms, said) {
        resume_unwind(panic);
    }
    skip(
        format_args!("the machine was late, by {late_ms} ms at worst"),
        "on a machine that is less busy",
    );
}

fn is_excused(late_ms: u64, said: &str) -> bool {
    late_ms > LATE_MS_MAX || said.contains(NOT_IN_TIME)
}

/// A thread that sends bytes across a pty and measures their delay: it waits for a processor as other threads do, and
/// for the kernel thread that carries the bytes.
struct Watch {
    over: Arc<AtomicBool>,
    late_ms: Arc<AtomicU64>,
    thread: thread::JoinHandle<()>,
}

impl Watch {
    fn start() -> Self {
        let (over, late_ms) = (Arc::<AtomicBool>::default(), Arc::<AtomicU64>::default());
        let thread = thread::spawn({
            let (over, late_ms) = (Arc::clone(&over), Arc::clone(&late_ms));
            move || watch(&over, &late_ms).expect("a pty is there to be watched")
        });
        Self { over, late_ms, thread }
    }

    fn stop(self) -> u64 {
        self.over.store(true, Ordering::Relaxed);
        self.thread.join().expect("the watch does not panic");
        self.late_ms.load(Ordering::Relaxed)
    }
}

#[expect(clippy::disallowed_methods, reason = "the machine's time is what is measured")]
fn watch(over: &AtomicBool, late_ms: &AtomicU64) -> rustix::io::Result<()> {
    let (near, far) = pty()?;
    let period = Timespec { tv_sec: 0, tv_nsec: PERIOD.subsec_nanos().into() };
    while !over.load(Ordering::Relaxed) {
        let began = Instant::now();
        rustix::io::write(&near, &[0])?;
        let mut has_come = false;
        while !has_come && !over.load(Ordering::Relaxed) {
            poll(&mut [PollFd::new(&far, PollFlags::IN)], Some(&period))?;
            has_come = rustix::io::read(&far, &mut [0; 16]).is_ok();
            let late = began.elapsed().as_millis();
            late_ms.fetch_max(u64::try_from(late).unwrap_or(u64::MAX), Ordering::Relaxed);
        }
        thread::sleep(PERIOD);
    }
    Ok(())
}

/// Opens both sides of a pty; the far one does not block.
fn pty() -> rustix::io::Result<(OwnedFd, OwnedFd)> {
    let near = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
    grantpt(&near)?;
    unlockpt(&near)?;
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let far = rustix::fs::open(ptsname(&near, Vec::new())?.as_c_str(), flags, Mode::empty())?;
    let mut termios = tcgetattr(&far)?;
    termios.make_raw();
    tcsetattr(&far, OptionalActions::Now, &termios)?;
    Ok((near, far))
}

#[cfg(test)]
mod tests {
    use super::{LATE_MS_MAX, NOT_IN_TIME, in_time, is_excused};

    #[test]
    fn only_a_machine_that_was_late_excuses_a_failure() {
        in_time(|| {});
        in_time(|| panic!("{NOT_IN_TIME}: late by more than 100 ms 1 times"));
        assert!(!is_excused(LATE_MS_MAX, "failed: gyro silent"));
        assert!(is_excused(LATE_MS_MAX + 1, "failed: gyro silent"));
    }
}
