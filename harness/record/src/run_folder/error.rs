//! Errors of a run folder.

use super::{RECORD, SUMMARY};
use crate::reader::RecordError;
use std::io;
use std::path::{Path, PathBuf};

/// An error of a run folder, with the path.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum RunFolderError {
    /// The folder has files, but none of a run.
    #[error("refused to replace {}: it holds files and is no run folder", path.display())]
    #[diagnostic(help("choose another folder with --out, or empty this one"))]
    Foreign {
        /// The folder.
        path: PathBuf,
    },
    /// There is a file of that name.
    #[error("refused to replace {}: it is a file and no folder", path.display())]
    #[diagnostic(help("choose another name with --out"))]
    NoFolder {
        /// The file.
        path: PathBuf,
    },
    /// Another run uses it.
    #[error("refused to write in {}: a run is going on there", path.display())]
    #[diagnostic(help("wait until it is over, or choose another folder"))]
    Busy {
        /// The folder.
        path: PathBuf,
    },
    /// It has no files of a run.
    #[error("no run in {}: neither {SUMMARY} nor {RECORD} is there", path.display())]
    NoRun {
        /// The folder.
        path: PathBuf,
        /// Which runs are in folders of it, if any.
        #[help]
        runs: Option<String>,
    },
    /// The run ended before it wrote its summary.
    #[error("no {}: the run was killed, or is still going on", path.display())]
    #[diagnostic(help("`hil check RUN` judges what a killed run recorded"))]
    NoSummary {
        /// The missing file.
        path: PathBuf,
    },
    /// A file or folder could not be created or written.
    #[error("failed to write {}", path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A file or folder could not be read.
    #[error("failed to read {}", path.display())]
    Read {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A file of an earlier run could not be removed.
    #[error("failed to remove {} of an earlier run", path.display())]
    Remove {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The summary is not valid.
    #[error("failed to understand {} as a summary", path.display())]
    Summary {
        /// The file.
        path: PathBuf,
        /// Why.
        source: serde_json::Error,
    },
    /// The record cannot be read.
    #[error("failed to read {}", path.display())]
    Record {
        /// The file.
        path: PathBuf,
        /// Why.
        #[source]
        #[diagnostic_source]
        source: RecordError,
    },
    /// An artifact's name is not a plain file name, or is reserved.
    #[error("failed to name a file of the run folder {name:?}")]
    #[diagnostic(help("a plain file name is needed, other than those that every run folder has"))]
    ArtifactName {
        /// The name.
        name: String,
    },
}

/// How many runs of a folder are named.
const NAMED_MAX: usize = 5;

impl RunFolderError {
    /// There is no run in `path`; says which runs its folders hold.
    pub(super) fn no_run(path: PathBuf) -> Self {
        let is_run =
            |folder: &Path| [SUMMARY, RECORD].iter().any(|name| folder.join(name).is_file());
        let entries = std::fs::read_dir(&path).into_iter().flatten().flatten();
        let runs = entries.map(|entry| entry.path()).filter(|folder| is_run(folder));
        let mut runs: Vec<String> = runs.map(|folder| folder.display().to_string()).collect();
        runs.sort();
        let more = if runs.len() > NAMED_MAX { ", ..." } else { "" };
        runs.truncate(NAMED_MAX);
        let runs = (!runs.is_empty())
            .then(|| format!("its folders hold runs: name one, {}{more}", runs.join(", ")));
        Self::NoRun { path, runs }
    }
}
