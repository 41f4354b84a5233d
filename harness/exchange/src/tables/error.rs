//! Errors of an export.

use record::run_folder::RunFolderError;
use std::path::PathBuf;

/// Why a run is not exported, or not completely.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum TablesError {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Folder(#[from] RunFolderError),
    /// The folder holds files that no export wrote.
    #[error("refused to replace {}: it holds files and is no package of tables", path.display())]
    #[diagnostic(help("choose another folder: hil export RUN --tables DIR"))]
    Foreign { path: PathBuf },
    /// A file cannot be written.
    #[error("failed to write {}", path.display())]
    Write { path: PathBuf, source: Box<dyn std::error::Error + Send + Sync> },
}

impl TablesError {
    /// Whether the caller can fix it, because the machine is not at fault.
    pub const fn is_bad_input(&self) -> bool {
        !matches!(self, Self::Write { .. })
    }
}
