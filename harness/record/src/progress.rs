//! Progress of a run.

use wire::time::Timestamp;

/// Progress of a run, as reported to its caller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Bench time.
    pub now: Timestamp,
    /// Steps done.
    pub steps_done: u64,
    /// Total number of steps.
    pub steps: u64,
}
