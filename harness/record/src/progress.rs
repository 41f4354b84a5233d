//! How far a run is.

use wire::time::Timestamp;

/// What a caller is told while a run goes on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Bench time.
    pub now: Timestamp,
    /// Steps done.
    pub steps_done: u64,
    /// Steps in all.
    pub steps: u64,
}
