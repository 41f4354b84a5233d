//! A run folder: all files of a run.
//!
//! | file | what |
//! |---|---|
//! | `summary.json` | [`Summary`] |
//! | `record.hilrec` | the record; see [`record::header`](crate::header) |
//! | `junit.xml` | the verdicts, for a build server |
//! | `report.html` | the report, for a person |
//! | others | files that the plan made; the summary names them |

mod error;
mod lock;

pub use crate::record_file::RecordFile;
pub use error::RunFolderError;

use crate::header::{Header, MAGIC};
use crate::kept::KeptSink;
use crate::locked::Locked;
use crate::outcome::Summary;
use crate::reader::{RecordError, RecordReader};
use crate::reading::{Teller, TellingFile};
use crate::sink::{FileSink, Level};
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// File name of the summary.
pub const SUMMARY: &str = "summary.json";
/// File name of the record.
pub const RECORD: &str = "record.hilrec";
/// File name of the verdicts for a build server.
pub const JUNIT: &str = "junit.xml";
/// File name of the report.
pub const REPORT: &str = "report.html";

const OURS: [&str; 4] = [SUMMARY, RECORD, JUNIT, REPORT];

const SUMMARY_BYTES_MAX: u64 = 64 * 1024 * 1024;

/// A folder that this crate made.
#[derive(Debug, Clone)]
pub struct RunFolder {
    path: PathBuf,
    teller: Teller,
    /// Lock held by the run that fills the folder, and by its clones.
    lock: Option<Arc<Locked>>,
}

impl RunFolder {
    /// Creates the folder. Removes the files of an earlier run, and no others. This run holds the folder until the
    /// returned value is dropped.
    ///
    /// # Errors
    /// [`RunFolderError::Foreign`] when it has files but no run; [`RunFolderError::Busy`] when another run uses it.
    pub fn create(path: impl Into<PathBuf>) -> Result<Self, RunFolderError> {
        let mut folder = Self { path: path.into(), teller: Teller::default(), lock: None };
        if folder.path.is_file() {
            return Err(RunFolderError::NoFolder { path: folder.path });
        }
        fs::create_dir_all(&folder.path)
            .map_err(|source| RunFolderError::Write { path: folder.path.clone(), source })?;
        folder.lock = lock::hold(&folder.path)?;
        let path = || folder.path.clone();
        let is_empty = fs::read_dir(&folder.path)
            .map_err(|source| RunFolderError::Read { path: path(), source })?
            .next()
            .is_none();
        if !is_empty {
            if !folder.holds_run() {
                return Err(RunFolderError::Foreign { path: path() });
            }
            folder.clear()?;
        }
        Ok(folder)
    }

    /// Removes the verdicts of an earlier run, which would stand for one that cannot begin. Leaves alone what is no run
    /// folder, and one that another run uses.
    pub fn outdate(path: &Path) {
        let folder = Self { path: path.to_owned(), teller: Teller::default(), lock: None };
        let verdicts = folder.file(JUNIT);
        if verdicts.is_file() && folder.holds_run() && lock::hold(path).is_ok() {
            // A run that begins says what is wrong with the folder.
            let _ = fs::remove_file(verdicts);
        }
    }

    /// Opens a folder with a run in it.
    ///
    /// # Errors
    /// [`RunFolderError::NoRun`] when it holds no run.
    pub fn open(path: impl Into<PathBuf>) -> Result<Self, RunFolderError> {
        let folder = Self { path: path.into(), teller: Teller::default(), lock: None };
        let holds_any = [SUMMARY, RECORD].iter().any(|name| folder.path.join(name).is_file());
        if holds_any { Ok(folder) } else { Err(RunFolderError::no_run(folder.path)) }
    }

    /// Holds the folder until the returned value is dropped, so that no run begins to fill it.
    ///
    /// # Errors
    /// [`RunFolderError::Busy`] when a run fills it.
    pub fn held(mut self) -> Result<Self, RunFolderError> {
        self.lock = lock::hold(&self.path)?;
        Ok(self)
    }

    /// Reports to `teller` how much of the record has been read.
    #[must_use]
    pub fn telling(mut self, teller: Teller) -> Self {
        self.teller = teller;
        self
    }

    /// Path of the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The path of this file in the folder.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Begins the record.
    pub fn record_sink(&self, header: &Header, level: Level) -> Result<KeptSink, RunFolderError> {
        let path = self.file(RECORD);
        RecordFile::create(&path)
            .and_then(|file| FileSink::new(file, header, level))
            .and_then(KeptSink::new)
            .map_err(|source| RunFolderError::Write { path, source })
    }

    /// Opens the record.
    pub fn records(&self) -> Result<RecordReader, RunFolderError> {
        let input = TellingFile::open(&self.file(RECORD), self.teller.clone());
        let opened = input.map_err(RecordError::Io).and_then(RecordReader::new);
        opened.map_err(|source| self.unreadable(source))
    }

    /// The error of a record that cannot be read, or not any further.
    pub fn unreadable(&self, source: RecordError) -> RunFolderError {
        RunFolderError::Record { path: self.file(RECORD), source }
    }

    /// Writes the summary.
    pub fn write_summary(&self, summary: &Summary) -> Result<(), RunFolderError> {
        let mut json = serde_json::to_vec_pretty(summary)
            .map_err(|source| RunFolderError::Summary { path: self.file(SUMMARY), source })?;
        json.push(b'\n');
        self.replace(SUMMARY, &json)
    }

    /// Reads the summary.
    pub fn summary(&self) -> Result<Summary, RunFolderError> {
        let path = self.file(SUMMARY);
        let json = match read_at_most(&path, SUMMARY_BYTES_MAX) {
            Ok(json) => json,
            Err(source) if source.kind() == io::ErrorKind::NotFound => {
                return Err(RunFolderError::NoSummary { path });
            }
            Err(source) => return Err(RunFolderError::Read { path, source }),
        };
        serde_json::from_slice(&json).map_err(|source| RunFolderError::Summary { path, source })
    }

    /// Reads the summary; `None` if the run was killed before it was written.
    pub fn summary_if_any(&self) -> Result<Option<Summary>, RunFolderError> {
        self.file(SUMMARY).exists().then(|| self.summary()).transpose()
    }

    /// Writes the verdicts for a build server.
    pub fn write_junit(&self, xml: &str) -> Result<(), RunFolderError> {
        self.replace(JUNIT, xml.as_bytes())
    }

    /// Writes the report.
    pub fn write_report(&self, html: &str) -> Result<(), RunFolderError> {
        self.replace(REPORT, html.as_bytes())
    }

    /// Writes a file that the plan made. The summary must name it.
    pub fn write_artifact(&self, name: &str, content: &[u8]) -> Result<(), RunFolderError> {
        if !is_artifact_name(name) {
            return Err(RunFolderError::ArtifactName { name: name.to_owned() });
        }
        self.replace(name, content)
    }

    /// Writes a temporary file and renames it, so that a reader sees the old file or the complete new one.
    fn replace(&self, name: &str, content: &[u8]) -> Result<(), RunFolderError> {
        let partial = self.file(&partial(name));
        let path = self.file(name);
        let done = fs::write(&partial, content).and_then(|()| fs::rename(&partial, &path));
        done.map_err(|source| {
            // Best effort; only the first error matters.
            let _ = fs::remove_file(&partial);
            RunFolderError::Write { path, source }
        })
    }

    /// Whether it holds a run, including one killed before it wrote a byte.
    fn holds_run(&self) -> bool {
        let begun = |mut magic: Vec<u8>| {
            magic.truncate(MAGIC.len());
            MAGIC.starts_with(&magic)
        };
        read_first(&self.file(RECORD), MAGIC.len()).is_ok_and(begun) || self.summary().is_ok()
    }

    /// Removes the files of an earlier run, the record last: after an interrupted removal the folder still counts as a
    /// run folder. A link to a device or a pipe holds no data of an earlier run and stays, because the user wants the
    /// record to go there.
    fn clear(&self) -> Result<(), RunFolderError> {
        let artifacts = self.summary().map(|summary| summary.artifacts).unwrap_or_default();
        let artifacts = artifacts.iter().map(String::as_str).filter(|name| is_artifact_name(name));
        let partial = OURS.map(partial);
        let partial = partial.iter().map(String::as_str);
        for name in artifacts.chain(partial).chain([REPORT, JUNIT, SUMMARY, RECORD]) {
            let path = self.file(name);
            if fs::metadata(&path).is_ok_and(|about| !about.is_file() && !about.is_dir()) {
                continue;
            }
            match fs::remove_file(&path) {
                Err(source) if source.kind() != io::ErrorKind::NotFound => {
                    return Err(RunFolderError::Remove { path, source });
                }
                _ => {}
            }
        }
        Ok(())
    }
}

/// Whether this is a plain file name that the crate does not use: an artifact can neither leave the folder nor replace
/// the record.
fn is_artifact_name(name: &str) -> bool {
    let mut components = Path::new(name).components();
    let plain = matches!(components.next(), Some(Component::Normal(only)) if only == name);
    plain && components.next().is_none() && !OURS.contains(&name) && !name.starts_with('.')
}

/// Name of the temporary file that is written until it is complete.
fn partial(name: &str) -> String {
    format!(".{name}.partial")
}

fn read_first(path: &Path, bytes: usize) -> io::Result<Vec<u8>> {
    let mut content = Vec::new();
    // A pipe at this path may have no writer, and opening it would block.
    match fs::metadata(path)?.is_file() {
        true => File::open(path)?.take(bytes as u64).read_to_end(&mut content)?,
        false => return Err(io::ErrorKind::InvalidInput.into()),
    };
    Ok(content)
}

fn read_at_most(path: &Path, bytes_max: u64) -> io::Result<Vec<u8>> {
    let mut content = Vec::new();
    File::open(path)?.take(bytes_max + 1).read_to_end(&mut content)?;
    match content.len() as u64 > bytes_max {
        true => {
            Err(io::Error::new(io::ErrorKind::FileTooLarge, format!("more than {bytes_max} bytes")))
        }
        false => Ok(content),
    }
}

#[cfg(test)]
mod tests;
