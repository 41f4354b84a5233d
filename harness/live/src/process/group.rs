//! Groups of processes that this one has started, each with all that its first process starts.

use rustix::process::{Pid, Signal, kill_process_group};
use std::sync::{Mutex, PoisonError};
use tokio::process::Child;

/// The groups that run: an exit that drops nothing ends them by this list.
static RUNNING: Mutex<Vec<Pid>> = Mutex::new(Vec::new());

/// A group, until it is dropped.
#[derive(Debug)]
pub(super) struct Group(Pid);

impl Group {
    /// The group of which `child` is the leader; `None` if it has ended.
    pub fn led_by(child: &Child) -> Option<Self> {
        let group = child.id().and_then(|id| Pid::from_raw(i32::try_from(id).ok()?))?;
        RUNNING.lock().unwrap_or_else(PoisonError::into_inner).push(group);
        Some(Self(group))
    }

    /// Sends a signal to each of its processes.
    pub fn signal(&self, signal: Signal) {
        // It may have ended in between, which is what is wanted.
        let _ = kill_process_group(self.0, signal);
    }
}

impl Drop for Group {
    fn drop(&mut self) {
        RUNNING.lock().unwrap_or_else(PoisonError::into_inner).retain(|group| *group != self.0);
    }
}

/// Kills every group that still runs, before the process exits without dropping what it holds.
pub fn kill_all() {
    for group in RUNNING.lock().unwrap_or_else(PoisonError::into_inner).drain(..) {
        let _ = kill_process_group(group, Signal::KILL);
    }
}
