//! The command line of a device under test.

pub use plan::command::{CommandError, fill};

use rustix::fs::{Access, access};
use std::path::{Path, PathBuf};

/// The program that a shell would start for that name or path; `None` if it cannot be started.
pub fn find(program: &Path) -> Option<PathBuf> {
    let can_run = |path: &PathBuf| path.is_file() && access(path, Access::EXEC_OK).is_ok();
    if program.components().count() > 1 {
        return Some(program.to_owned()).filter(can_run);
    }
    let folders = std::env::var_os("PATH")?;
    std::env::split_paths(&folders).map(|folder| folder.join(program)).find(can_run)
}
