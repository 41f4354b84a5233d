//! Projects in folders that go away with their test.

use harness::{Trial, TrialError};
use std::path::Path;
use tempfile::TempDir;

/// A folder with these files, by their paths in it.
///
/// # Panics
/// When they cannot be written.
pub fn of(files: impl IntoIterator<Item = (impl AsRef<Path>, impl AsRef<[u8]>)>) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder for the test");
    write(folder.path(), files);
    folder
}

/// Writes these files, by their paths in the folder.
///
/// # Panics
/// When they cannot be written.
pub fn write(folder: &Path, files: impl IntoIterator<Item = (impl AsRef<Path>, impl AsRef<[u8]>)>) {
    for (path, content) in files {
        let path = folder.join(path);
        let parent = path.parent().expect("a file lies in a folder");
        std::fs::create_dir_all(parent).expect("the folder is the test's own");
        std::fs::write(path, content).expect("the folder is the test's own");
    }
}

/// The plan of this name in the folder.
///
/// # Errors
/// As [`Trial::load`].
pub fn load(folder: &TempDir, plan: &str) -> Result<Trial, TrialError> {
    Trial::load(&folder.path().join(plan).to_string_lossy())
}
