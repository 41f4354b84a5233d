//! Projects in folders that are deleted with their test.

use harness::{Trial, TrialError};
use std::path::Path;
use tempfile::TempDir;

/// Creates a folder with these files, given by relative paths.
///
/// # Panics
/// When they cannot be written.
pub fn of(files: impl IntoIterator<Item = (impl AsRef<Path>, impl AsRef<[u8]>)>) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder for the test");
    write(folder.path(), files);
    folder
}

/// Writes these files, given by paths relative to the folder.
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

/// What an error says, and its causes.
pub fn why(error: &TrialError) -> String {
    let all = std::iter::successors(Some(error as &dyn std::error::Error), |one| one.source());
    all.map(ToString::to_string).collect::<Vec<_>>().join(": ")
}

/// Loads the plan of this name from the folder.
///
/// # Errors
/// As [`Trial::load`].
pub fn load(folder: &TempDir, plan: &str) -> Result<Trial, TrialError> {
    Trial::load(&folder.path().join(plan).to_string_lossy())
}
