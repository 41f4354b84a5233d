//! Locks that end with their holder.

use std::fs::{File, TryLockError};
use std::io::{Error, ErrorKind};
use std::path::Path;

/// A locked file, until this is dropped. To close the file would not do: a child process that another thread is starting
/// has it until it runs its program, and the lock with it.
#[derive(Debug)]
pub struct Locked(pub File);

impl Locked {
    /// Locks a folder itself: that leaves no file, and ends with the process, even when that is killed. `None` if the file
    /// system has no such locks.
    ///
    /// # Errors
    /// [`ErrorKind::WouldBlock`] if another holds it; else, when it cannot be opened.
    pub fn folder(folder: &Path) -> Result<Option<Self>, Error> {
        let file = File::open(folder)?;
        match file.try_lock() {
            Ok(()) => Ok(Some(Self(file))),
            Err(TryLockError::WouldBlock) => Err(ErrorKind::WouldBlock.into()),
            Err(TryLockError::Error(_)) => Ok(None),
        }
    }
}

impl Drop for Locked {
    fn drop(&mut self) {
        // Where it fails, the lock ends as the last process closes the file.
        let _ = self.0.unlock();
    }
}
