//! How late the machine is with its work for other programs.
//!
//! The harness's loop may be in time while the program under test is not: a kernel thread carries the bytes of a pty,
//! and a program waits for a processor. Therefore a byte constantly crosses a pty of the harness's own, and the kernel
//! reports how long each thread of a program has waited (`/proc/PID/task/TID/schedstat`).

use ports::pty::{Pty, PtyError};
use rustix::fs::OFlags;
use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::Write as _;
use std::os::unix::fs::OpenOptionsExt as _;
use wire::time::{Span, Timestamp};

/// Number of probe bytes within the lateness limit of the harness.
const PROBES: i64 = 10;
/// Shortest and longest period of the probe: assumptions, a tenth of a percent of a processor, and a sample period of
/// the gyro.
const PERIODS: (Span, Span) = (Span::from_millis(1), Span::from_millis(10));

#[derive(Debug)]
pub(super) struct MachineWatch {
    near: Pty,
    far: File,
    period: Span,
    is_under_way: bool,
    /// When the last byte arrived: until then nothing was delayed.
    arrived: Timestamp,
    due: Timestamp,
    /// Time that each thread of each program has waited for a processor so far.
    waited: BTreeMap<(u32, String), Span>,
}

impl MachineWatch {
    /// Needs a tokio runtime with IO enabled.
    pub(super) fn new(now: Timestamp, late_max: Span) -> Result<Self, PtyError> {
        let near = Pty::open()?;
        let flags = OFlags::NOCTTY | OFlags::NONBLOCK;
        let far = OpenOptions::new()
            .write(true)
            .custom_flags(flags.bits().cast_signed())
            .open(near.path())
            .map_err(PtyError::other_side)?;
        let period = (late_max / PROBES).clamp(PERIODS.0, PERIODS.1);
        let waited = BTreeMap::new();
        Ok(Self { near, far, period, is_under_way: false, arrived: now, due: now, waited })
    }

    pub(super) fn wake(&mut self, now: Timestamp) {
        if now >= self.due && self.far.write(&[0]).is_ok() {
            self.is_under_way = true;
            self.due = Timestamp::MAX;
        }
    }

    pub(super) const fn next_wakeup(&self) -> Timestamp {
        self.due
    }

    /// Waits until the byte arrives. Cancel-safe.
    pub(super) async fn arrives(&self) {
        let mut buffer = [0; 16];
        if self.near.read(&mut buffer).await.is_err() {
            std::future::pending::<()>().await;
        }
    }

    /// Takes the arrival; returns how long something may have been under way.
    pub(super) fn arrived(&mut self, now: Timestamp) -> Span {
        let late = self.late(now);
        self.is_under_way = false;
        self.arrived = now;
        self.due = now + self.period;
        late
    }

    /// How long a byte may have been under way; zero otherwise.
    pub(super) fn late(&self, now: Timestamp) -> Span {
        if self.is_under_way { now - self.arrived } else { Span::ZERO }
    }

    /// The longest wait of a thread of these processes for a processor since the last call.
    pub(super) fn look(&mut self, processes: impl IntoIterator<Item = u32>) -> Span {
        let mut longest = Span::ZERO;
        for process in processes {
            // A process that is gone has no threads.
            let threads = fs::read_dir(format!("/proc/{process}/task")).into_iter().flatten();
            for thread in threads.flatten() {
                let waited = fs::read_to_string(thread.path().join("schedstat"));
                let Some(waited) = waited.ok().as_deref().and_then(run_delay) else { continue };
                let thread = (process, thread.file_name().to_string_lossy().into_owned());
                if let Some(before) = self.waited.insert(thread, waited) {
                    longest = longest.max(waited - before);
                }
            }
        }
        longest
    }
}

/// The second of three numbers: time on a run queue, ns.
fn run_delay(schedstat: &str) -> Option<Span> {
    schedstat.split_ascii_whitespace().nth(1)?.parse().ok().map(Span::from_nanos)
}

#[cfg(test)]
mod tests {
    use super::{MachineWatch, Span, Timestamp, run_delay};

    #[test]
    fn the_kernel_tells_how_long_a_thread_has_waited() {
        assert_eq!(run_delay("123 4567 8\n"), Some(Span::from_nanos(4_567)));
        assert_eq!(run_delay("123"), None);
    }

    #[tokio::test]
    async fn a_byte_that_arrives_late_is_as_late_as_anything_may_be() {
        let at = |ms| Timestamp::ZERO + Span::from_millis(ms);
        let mut watch = MachineWatch::new(at(0), Span::from_millis(100)).unwrap();
        watch.wake(at(0));
        watch.arrives().await;
        assert_eq!(watch.arrived(at(1)), Span::from_millis(1));
        assert_eq!((watch.late(at(9)), watch.next_wakeup()), (Span::ZERO, at(11)));
        watch.wake(at(11));
        watch.arrives().await;
        assert_eq!(watch.late(at(121)), Span::from_millis(120), "since the first arrived");
        assert_eq!(watch.arrived(at(121)), Span::from_millis(120));
        watch.wake(at(131));
        assert_eq!(watch.late(at(132)), Span::from_millis(11));
    }

    #[tokio::test]
    async fn threads_of_this_process_are_found() {
        let mut watch = MachineWatch::new(Timestamp::ZERO, Span::from_millis(100)).unwrap();
        assert_eq!(watch.look([std::process::id()]), Span::ZERO, "nothing to compare with");
        assert!(!watch.waited.is_empty());
        assert!(watch.look([std::process::id(), u32::MAX]) >= Span::ZERO);
    }
}
