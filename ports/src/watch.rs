//! Readiness of a descriptor that the event loop does not own.

use std::io;
use std::os::fd::AsRawFd;
use tokio::io::Interest;
use tokio::io::unix::AsyncFd;

/// Watches `port` until dropped. Must be called within a tokio runtime with IO enabled.
///
/// # Errors
/// If the system cannot watch more descriptors, or not this kind.
#[expect(
    deprecated,
    reason = "its successor is unsafe, which is forbidden here; the types that come here own their \
              descriptor and keep it"
)]
pub fn watch<T: AsRawFd>(port: T, interest: Interest) -> io::Result<AsyncFd<T>> {
    AsyncFd::with_interest(port, interest)
}
