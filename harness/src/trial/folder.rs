//! Output folder of a trial.

use super::TrialError;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A given folder, which stays, or a temporary one.
#[derive(Debug)]
pub(super) enum Folder {
    Given(PathBuf),
    Temporary(TempDir),
}

impl Folder {
    /// The `given` folder, or a temporary one.
    pub(super) fn of(given: Option<&Path>) -> Result<Self, TrialError> {
        match given {
            Some(path) => Ok(Self::Given(path.to_owned())),
            None => tempfile::Builder::new()
                .prefix("hil-")
                .tempdir()
                .map(Self::Temporary)
                .map_err(TrialError::Temporary),
        }
    }

    pub(super) fn path(&self) -> &Path {
        match self {
            Self::Given(path) => path,
            Self::Temporary(folder) => folder.path(),
        }
    }

    /// Keeps the folder, even if it is temporary.
    pub(super) fn keep(&mut self) {
        if let Self::Temporary(folder) = self {
            folder.disable_cleanup(true);
        }
    }
}

/// Keeps the folder of a failing test.
impl Drop for Folder {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.keep();
        }
    }
}
