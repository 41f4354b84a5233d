//! Groups of processes that this one has started, each with all that its first process starts.

use rustix::process::{Pid, Signal, kill_process_group};
use std::os::unix::process::CommandExt as _;
use std::process::{self, Command, Stdio};
use std::sync::{Mutex, PoisonError};
use tokio::process::Child;

/// The groups that run: an exit that drops nothing ends them by this list.
static RUNNING: Mutex<Vec<Pid>> = Mutex::new(Vec::new());

/// Waits for the end of its input, which comes when nobody holds the other end any more, and ends the group `$0` as a run
/// does: SIGTERM, and SIGKILL if it still runs 3 s later.
const WATCH: &str = "read -r _; kill -s TERM -- -$0 && sleep 3 && kill -s KILL -- -$0";

/// A group, until it is dropped.
#[derive(Debug)]
pub(super) struct Group {
    id: Pid,
    /// Ends the group after a `kill -9` of this process, which alone holds its input. `None` where it could not start.
    watcher: Option<process::Child>,
}

impl Group {
    /// The group of which `child` is the leader; `None` if it has ended.
    pub fn led_by(child: &Child) -> Option<Self> {
        let id = child.id().and_then(|id| Pid::from_raw(i32::try_from(id).ok()?))?;
        RUNNING.lock().unwrap_or_else(PoisonError::into_inner).push(id);
        let mut watcher = Command::new("/bin/sh");
        watcher.args(["-c", WATCH, &id.to_string()]).process_group(0);
        watcher.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null());
        Some(Self { id, watcher: watcher.spawn().ok() })
    }

    /// Sends a signal to each of its processes.
    pub fn signal(&self, signal: Signal) {
        // It may have ended in between, which is what is wanted.
        let _ = kill_process_group(self.id, signal);
    }
}

impl Drop for Group {
    fn drop(&mut self) {
        RUNNING.lock().unwrap_or_else(PoisonError::into_inner).retain(|group| *group != self.id);
        if let Some(watcher) = &mut self.watcher {
            let _ = watcher.kill();
            let _ = watcher.wait();
        }
    }
}

/// Kills every group that still runs, before the process exits without dropping what it holds.
pub fn kill_all() {
    for group in RUNNING.lock().unwrap_or_else(PoisonError::into_inner).drain(..) {
        let _ = kill_process_group(group, Signal::KILL);
    }
}
