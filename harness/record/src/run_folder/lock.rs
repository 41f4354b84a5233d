//! Allows one run at a time in a folder.

use super::RunFolderError;
use crate::locked::Locked;
use std::io::ErrorKind;
use std::path::Path;
use std::sync::Arc;

/// Holds a folder for a run.
#[derive(Debug, Clone)]
pub(super) struct Lock {
    _held: Arc<Locked>,
}

impl Lock {
    /// Locks this folder; `None` if the file system has no such locks.
    pub(super) fn of(folder: &Path) -> Result<Option<Self>, RunFolderError> {
        let path = folder.to_owned();
        match Locked::folder(folder) {
            Ok(held) => Ok(held.map(|held| Self { _held: Arc::new(held) })),
            Err(source) if source.kind() == ErrorKind::WouldBlock => {
                Err(RunFolderError::Busy { path })
            }
            Err(source) => Err(RunFolderError::Read { path, source }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Lock, RunFolderError};

    #[test]
    fn a_folder_is_free_after_its_run_even_if_a_child_still_has_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let held = Lock::of(folder.path()).unwrap().unwrap();
        // What a child process has until it runs its program.
        let _inherited = held._held.0.try_clone().unwrap();
        let busy = Lock::of(folder.path());
        assert!(matches!(busy, Err(RunFolderError::Busy { .. })), "{busy:?}");
        drop(held);
        assert!(matches!(Lock::of(folder.path()), Ok(Some(_))));
    }
}
