//! What the wires share: how long they wait for what the kernel has not delivered yet, and how messages show it.

use record::text::ShownFrame;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use std::io;
use std::os::fd::AsFd;
use std::time::Duration;
use wire::can::CanFrame;

/// What was written comes out within this wall-clock time. Assumption: it takes microseconds, and a few milliseconds on
/// a busy machine; beyond this it is stuck.
pub(super) const LIMIT: Duration = Duration::from_secs(10);

/// Most reads for one packet or frame: each byte may come alone, and a signal may end a wait early.
pub(super) const READS_MAX: usize = 1_000;

/// Waits until there is something to read, or an error; `false` if there is neither within `limit`.
///
/// # Errors
/// What the system reports.
pub(super) fn readable(port: &impl AsFd, limit: Duration) -> io::Result<bool> {
    let limit = Timespec::try_from(limit).map_err(io::Error::other)?;
    match poll(&mut [PollFd::new(port, PollFlags::IN)], Some(&limit)) {
        Ok(count) => Ok(count > 0),
        // A signal arrived: the caller tries again.
        Err(Errno::INTR) => Ok(true),
        Err(cause) => Err(cause.into()),
    }
}

pub(super) fn shown_bytes(bytes: &[u8]) -> String {
    if bytes.is_empty() {
        return "nothing".to_owned();
    }
    format!("\"{}\"", bytes.escape_ascii())
}

pub(super) fn shown_frame(frame: &CanFrame) -> String {
    ShownFrame(*frame).to_string()
}
