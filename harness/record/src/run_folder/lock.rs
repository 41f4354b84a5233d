//! One run at a time in a folder.

use super::RunFolderError;
use std::fs::{File, TryLockError};
use std::path::Path;
use std::sync::Arc;

/// A folder that is held by a run. The lock is of the folder itself: it leaves no file behind, and ends with the process however
/// that ends.
#[derive(Debug, Clone)]
pub(super) struct Lock {
    _held: Arc<File>,
}

/// Who holds a folder is no part of what is in it.
impl PartialEq for Lock {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for Lock {}

impl Lock {
    /// Holds this folder; none on a file system that has no such locks.
    pub(super) fn of(folder: &Path) -> Result<Option<Self>, RunFolderError> {
        let path = || folder.to_owned();
        let file =
            File::open(folder).map_err(|source| RunFolderError::Read { path: path(), source })?;
        match file.try_lock() {
            Ok(()) => Ok(Some(Self { _held: Arc::new(file) })),
            Err(TryLockError::WouldBlock) => Err(RunFolderError::Busy { path: path() }),
            Err(TryLockError::Error(_)) => Ok(None),
        }
    }
}
