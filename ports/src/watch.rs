//! Readiness of a descriptor that is not the event loop's own.

use std::io;
use std::os::fd::AsRawFd;
use tokio::io::Interest;
use tokio::io::unix::AsyncFd;

/// Watches `port` until it is dropped. Called within a tokio runtime that has IO enabled.
///
/// # Errors
/// When the system watches no more descriptors, or not this kind.
#[expect(
    deprecated,
    reason = "its successor is unsafe, which is forbidden here; the types that come here own their \
              descriptor and keep it"
)]
pub fn watch<T: AsRawFd>(port: T, interest: Interest) -> io::Result<AsyncFd<T>> {
    AsyncFd::with_interest(port, interest)
}
