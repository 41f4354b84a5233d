//! python-can, python-pcapng and asammdf as references, through the scripts in `tests/interop`.

use super::rows::{read, row, rows, sample, write};
use bus_log::{Entry, Payload};
use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tests::rooms::root;

fn python() -> OsString {
    std::env::var_os("HIL_TESTS_PYTHON").unwrap_or_else(|| "python3".into())
}

fn script(name: &str) -> PathBuf {
    root().join("tests/interop").join(name)
}

/// Whether all reference packages are installed.
fn is_there() -> bool {
    let loaded = Command::new(python()).arg(script("load.py")).output();
    if loaded.is_ok_and(|loaded| loaded.status.success()) {
        return true;
    }
    let python = python();
    let why = format!("{} has no python-can, python-pcapng or asammdf", python.to_string_lossy());
    skips::skip(why, "tests/interop/README.md says how to install them");
    false
}

/// Returns the output of the script with `input` on its stdin. Its clock is in UTC, as are the dates in our logs.
fn run(name: &str, what: &str, path: &Path, input: &str) -> String {
    let mut child = Command::new(python())
        .arg(script(name))
        .arg(what)
        .arg(path)
        .env("TZ", "UTC")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(input.as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{name} {what} {}", path.display());
    String::from_utf8(output.stdout).unwrap()
}

/// Script that reads and writes each format, by file extension.
const REFEREES: [(&str, &str); 6] = [
    ("python_can_rows.py", "log"),
    ("python_can_rows.py", "asc"),
    ("python_can_rows.py", "trc"),
    ("python_can_rows.py", "blf"),
    ("pcapng_rows.py", "pcapng"),
    ("mdf4_rows.py", "mf4"),
];

/// Returns the row of an entry as python-can reads it from a TRC file; `None` for an error frame, which it skips.
fn row_of_trc(entry: &Entry) -> Option<String> {
    let Payload::Frame(frame) = &entry.payload else { return None };
    let row = row(entry);
    let mut words: Vec<_> = row.split(' ').collect();
    if frame.fd_flags().is_some() {
        // PEAK uses `FE` for ESI alone and `BI` for both flags; python-can 4.6 swaps them, without BRS.
        words[4] = match words[4] {
            "2" => "3",
            "3" => "2",
            other => other,
        };
    }
    Some(words.join(" ") + "\n")
}

/// Each reference reads what we write.
#[test]
fn what_is_written_here_python_reads() {
    if !is_there() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let entries = sample();
    for (script, end) in REFEREES {
        let path = dir.path().join("bus").with_extension(end);
        write(&path, &entries);
        let expected = match end {
            "trc" => entries.iter().filter_map(row_of_trc).collect(),
            _ => rows(&entries),
        };
        assert_eq!(run(script, "read", &path, ""), expected, "{end}");
    }
}

/// We read what each reference writes.
#[test]
fn what_python_writes_is_read_here() {
    if !is_there() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    for (script, end) in REFEREES {
        let path = dir.path().join("bus").with_extension(end);
        let mut entries = sample();
        if end == "trc" {
            // There python-can writes no remote requests, CAN FD frames or error frames.
            let is_plain = |entry: &Entry| match &entry.payload {
                Payload::Frame(frame) => frame.fd_flags().is_none() && !frame.is_remote(),
                _ => false,
            };
            entries.retain(is_plain);
        }
        run(script, "write", &path, &rows(&entries));
        let kept = |entry: &Entry| match (&entry.payload, end) {
            // The candump logs of python-can do not contain the length of a remote request.
            (Payload::Frame(frame), "log") if frame.is_remote() => {
                let row = row(entry);
                let mut words: Vec<_> = row.split(' ').collect();
                words[5] = "0";
                words.join(" ")
            }
            _ => row(entry),
        };
        let expected: Vec<_> = entries.iter().map(kept).collect();
        let found: Vec<_> = read(&path).iter().map(row).collect();
        assert_eq!(found, expected, "{end}");
    }
}

/// asammdf writes MDF files with several layouts.
#[test]
fn mdf_files_of_asammdf_are_read_however_they_are_compressed() {
    if !is_there() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("bus.mf4");
    let entries = sample();
    for way in ["write-plain", "write-transposed"] {
        run("mdf4_rows.py", way, &path, &rows(&entries));
        let found: Vec<_> = read(&path).iter().map(row).collect();
        let expected: Vec<_> = entries.iter().map(row).collect();
        assert_eq!(found, expected, "{way}");
    }
}
