//! Allows one run at a time in a folder.

use super::RunFolderError;
use crate::locked::Locked;
use std::io::ErrorKind;
use std::path::Path;
use std::sync::Arc;

/// Locks this folder for a run; `None` if the file system has no such locks.
pub(super) fn hold(folder: &Path) -> Result<Option<Arc<Locked>>, RunFolderError> {
    let path = folder.to_owned();
    match Locked::folder(folder) {
        Ok(held) => Ok(held.map(Arc::new)),
        Err(source) if source.kind() == ErrorKind::WouldBlock => Err(RunFolderError::Busy { path }),
        Err(source) => Err(RunFolderError::Read { path, source }),
    }
}

#[cfg(test)]
mod tests {
    use super::{RunFolderError, hold};

    #[test]
    fn a_folder_is_free_after_its_run_even_if_a_child_still_has_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let held = hold(folder.path()).unwrap().unwrap();
        // What a child process has until it runs its program.
        let _inherited = held.0.try_clone().unwrap();
        let busy = hold(folder.path());
        assert!(matches!(busy, Err(RunFolderError::Busy { .. })), "{busy:?}");
        drop(held);
        assert!(matches!(hold(folder.path()), Ok(Some(_))));
    }
}
