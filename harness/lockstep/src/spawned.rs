//! The started process, and the thread that is its parent.
//!
//! The kernel kills the process when that thread ends (`PR_SET_PDEATHSIG`, set by the shim). Therefore the thread only
//! waits for the process, and the caller's threads may come and go.

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, Signal, kill_process_group, pidfd_open};
use std::io::{self, ErrorKind};
use std::process::{Command, ExitStatus};
use std::sync::mpsc::{Receiver, channel};
use std::thread::{self, Builder, JoinHandle};
use std::time::Duration;

/// Retries, and the pause between them, for an executable that another process has open for writing.
const BUSY_TRIES: u32 = 200;
const BUSY_SPAN: Duration = Duration::from_millis(5);

/// The started process. Dropping it kills its process group.
#[derive(Debug)]
pub(crate) struct Spawned {
    pid: i32,
    statuses: Receiver<ExitStatus>,
    status: Option<ExitStatus>,
    parent: Option<JoinHandle<()>>,
}

impl Spawned {
    pub(crate) fn start(mut command: Command) -> io::Result<Self> {
        let (sender, statuses) = channel();
        let (pid_sender, pids) = channel();
        let parent = Builder::new().name("lockstep".to_owned()).spawn(move || {
            let mut started = command.spawn();
            // A file that was just written: the fork of another thread may have it open for a moment.
            for _ in 0..BUSY_TRIES {
                match &started {
                    Err(cause) if cause.kind() == ErrorKind::ExecutableFileBusy => {
                        thread::park_timeout(BUSY_SPAN);
                        started = command.spawn();
                    }
                    _ => break,
                }
            }
            // From here on its files belong to it alone.
            drop(command);
            match started {
                Ok(mut child) => {
                    // There is no receiver if the harness has given up meanwhile.
                    let _ = pid_sender.send(Ok(child.id() as i32));
                    if let Ok(status) = child.wait() {
                        let _ = sender.send(status);
                    }
                }
                Err(cause) => {
                    let _ = pid_sender.send(Err(cause));
                }
            }
        })?;
        let pid = pids.recv().map_err(io::Error::other)??;
        Ok(Self { pid, statuses, status: None, parent: Some(parent) })
    }

    /// Its process id, which is also that of its process group.
    pub(crate) fn pid(&self) -> i32 {
        self.pid
    }

    /// Returns its exit status; `None` if it has not ended within `limit`.
    pub(crate) fn wait(&mut self, limit: Duration) -> Option<ExitStatus> {
        if self.status.is_none() {
            self.status = self.statuses.recv_timeout(limit).ok();
        }
        self.status
    }

    pub(crate) fn kill(&self) {
        if let Some(group) = Pid::from_raw(self.pid) {
            // It may be gone already, which is fine.
            let _ = kill_process_group(group, Signal::KILL);
        }
    }
}

impl Drop for Spawned {
    fn drop(&mut self) {
        self.kill();
        if let Some(parent) = self.parent.take() {
            let _ = parent.join();
        }
    }
}

/// Whether a process has ended, even if its parent has not reaped it yet.
pub(crate) fn is_gone(pid: i32) -> bool {
    wait_for_death(pid, Duration::ZERO)
}

pub(crate) fn wait_for_death(pid: i32, limit: Duration) -> bool {
    let Some(pid) = Pid::from_raw(pid) else { return true };
    let Ok(process) = pidfd_open(pid, PidfdFlags::empty()) else { return true };
    let limit =
        Timespec { tv_sec: limit.as_secs() as i64, tv_nsec: i64::from(limit.subsec_nanos()) };
    let mut ends = [PollFd::new(&process, PollFlags::IN)];
    matches!(poll(&mut ends, Some(&limit)), Ok(1..))
}
