//! Folders of runs: what is in them, and what is left alone.

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
