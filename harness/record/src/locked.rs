//! Locks that end with their holder.

use std::fs::File;

/// A locked file, until this is dropped. To close the file would not do: a child process that another thread is starting
/// has it until it runs its program, and the lock with it.
#[derive(Debug)]
pub struct Locked(pub File);

impl Drop for Locked {
    fn drop(&mut self) {
        // Where it fails, the lock ends as the last process closes the file.
        let _ = self.0.unlock();
    }
}
