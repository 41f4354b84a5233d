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
use crate::outcome::Summary;
use crate::reader::{RecordError, RecordReader};
use crate::reading::{Teller, TellingFile};
use crate::sink::{FileSink, Level};
use lock::Lock;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

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
    lock: Option<Lock>,
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
        folder.lock = Lock::of(&folder.path)?;
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
        if verdicts.is_file() && folder.holds_run() && Lock::of(path).is_ok() {
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
        self.lock = Lock::of(&self.path)?;
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
mod tests {
    use super::{JUNIT, RECORD, REPORT, RunFolder, RunFolderError, SUMMARY};
    use crate::header::Header;
    use crate::outcome::samples::summary;
    use crate::samples::one_of_each;
    use crate::sink::{Level, RecordSink};
    use std::fs;

    fn folder() -> (tempfile::TempDir, RunFolder) {
        let dir = tempfile::tempdir().unwrap();
        let folder = RunFolder::create(dir.path().join("a/run")).unwrap();
        (dir, folder)
    }

    fn names(folder: &RunFolder) -> Vec<String> {
        let entries = fs::read_dir(folder.path()).unwrap();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn what_is_written_is_read_back() {
        let (_dir, folder) = folder();
        let mut sink = folder.record_sink(&Header::default(), Level::Full).unwrap();
        one_of_each().into_iter().for_each(|record| sink.record(record));
        sink.finish();
        folder.write_summary(&summary()).unwrap();
        folder.write_junit("<testsuites/>").unwrap();
        folder.write_report("<!DOCTYPE html>").unwrap();
        folder.write_artifact("calibration.toml", b"scale = 1").unwrap();

        assert_eq!(names(&folder), ["calibration.toml", JUNIT, RECORD, REPORT, SUMMARY]);
        let again = RunFolder::open(folder.path()).unwrap();
        assert_eq!(again.summary().unwrap(), summary());
        let records: Vec<_> = again.records().unwrap().map(Result::unwrap).collect();
        assert_eq!(records, one_of_each());
    }

    #[test]
    fn an_earlier_run_is_replaced_and_other_files_stay() {
        let (_dir, folder) = folder();
        folder.write_summary(&summary()).unwrap();
        folder.write_artifact("calibration.toml", b"old").unwrap();
        fs::write(folder.file("notes.txt"), "mine").unwrap();
        let path = folder.path().to_owned();
        drop(folder);
        assert_eq!(names(&RunFolder::create(path).unwrap()), ["notes.txt"]);
    }

    #[test]
    fn a_run_that_was_killed_is_known_by_its_record() {
        let (_dir, folder) = folder();
        drop(folder.record_sink(&Header::default(), Level::Full).unwrap());
        let path = folder.path().to_owned();
        drop(folder);
        assert!(names(&RunFolder::create(path).unwrap()).is_empty());
    }

    #[test]
    fn a_run_that_was_killed_at_once_is_known_too() {
        let (_dir, folder) = folder();
        let whole = folder.record_sink(&Header::default(), Level::Full);
        drop(whole.unwrap());
        let bytes = fs::read(folder.file(RECORD)).unwrap();
        let path = folder.path().to_owned();
        drop(folder);
        for length in [0, 1, 7, 8, 30] {
            fs::write(path.join(RECORD), &bytes[..length]).unwrap();
            fs::write(path.join(format!(".{SUMMARY}.partial")), "{").unwrap();
            assert!(names(&RunFolder::create(&path).unwrap()).is_empty(), "{length}");
        }
    }

    #[test]
    fn the_second_run_in_a_folder_is_refused_while_the_first_goes_on() {
        let (_dir, folder) = folder();
        let mut sink = folder.record_sink(&Header::default(), Level::Full).unwrap();
        let error = RunFolder::create(folder.path()).unwrap_err();
        assert!(matches!(&error, RunFolderError::Busy { .. }), "{error}");
        assert!(error.to_string().contains(folder.path().to_str().unwrap()), "{error}");
        one_of_each().into_iter().for_each(|record| sink.record(record));
        sink.finish();
        let records: Vec<_> = folder.records().unwrap().map(Result::unwrap).collect();
        assert_eq!(records, one_of_each(), "the first lost nothing by it");
        let path = folder.path().to_owned();
        drop(folder);
        RunFolder::create(path).unwrap();
    }

    #[test]
    fn foreign_folders_are_left_alone() {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join(SUMMARY), r#"{"other": "program"}"#).unwrap();
        let error = RunFolder::create(dir.path()).unwrap_err();
        assert!(matches!(error, RunFolderError::Foreign { .. }), "{error}");
        assert!(dir.path().join(SUMMARY).exists());
        let empty = tempfile::tempdir().unwrap();
        let error = RunFolder::open(empty.path()).unwrap_err();
        assert!(matches!(error, RunFolderError::NoRun { runs: None, .. }), "{error}");
        let error = RunFolder::open(dir.path().parent().unwrap().join("no-such")).unwrap_err();
        assert!(matches!(error, RunFolderError::NoRun { runs: None, .. }), "{error}");
        let (name, parent) = (dir.path().file_name().unwrap(), tempfile::tempdir().unwrap());
        fs::create_dir(parent.path().join(name)).unwrap();
        fs::write(parent.path().join(name).join(SUMMARY), "{}").unwrap();
        let error = RunFolder::open(parent.path()).unwrap_err();
        let RunFolderError::NoRun { runs: Some(runs), .. } = error else { panic!("{error}") };
        assert!(runs.contains(name.to_str().unwrap()), "{runs}");
    }

    #[test]
    fn artifacts_cannot_leave_the_folder_or_replace_our_files() {
        let (_dir, folder) = folder();
        for name in ["../x", "/x", "a/b", "", ".", "..", "x/", RECORD, ".hidden"] {
            let error = folder.write_artifact(name, b"").unwrap_err();
            assert!(matches!(error, RunFolderError::ArtifactName { .. }), "{name}");
        }
        assert!(names(&folder).is_empty());
    }

    #[test]
    fn errors_name_the_file_and_the_cause() {
        let (_dir, folder) = folder();
        fs::create_dir(folder.file(REPORT)).unwrap();
        let error = folder.write_report("x").unwrap_err();
        assert!(error.to_string().starts_with("failed to write /"), "{error}");
        assert!(error.to_string().ends_with(REPORT), "{error}");
        assert!(std::error::Error::source(&error).is_some());
        assert_eq!(names(&folder), [REPORT], "nothing partial stays");
        fs::write(folder.file(RECORD), "nothing of ours").unwrap();
        let error = folder.records().unwrap_err();
        let source = std::error::Error::source(&error).unwrap().to_string();
        assert_eq!(source, "not a record file");
    }
}
