//! What can go wrong with an export.

use record::run_folder::RunFolderError;
use std::path::PathBuf;

/// Why a run is not exported, or not to its end.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum TablesError {
    /// The run cannot be read.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Folder(#[from] RunFolderError),
    /// The folder holds a package that we did not write, or a table without a package.
    #[error("refused to replace {}: it is of no package of tables", path.display())]
    #[diagnostic(help("choose another folder: hil export RUN --tables DIR"))]
    Foreign {
        /// The package, or the table.
        path: PathBuf,
    },
    /// A file cannot be written.
    #[error("failed to write {}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

impl TablesError {
    /// Who calls it can mend it: it is not the machine that is at fault.
    pub const fn is_bad_input(&self) -> bool {
        !matches!(self, Self::Write { .. })
    }
}
