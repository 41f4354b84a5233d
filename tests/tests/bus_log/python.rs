//! python-can and python-pcapng as referees, by the scripts in `tests/interop`.

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

/// Both referees are there.
fn is_there() -> bool {
    let loaded = Command::new(python()).arg(script("load.py")).output();
    if loaded.is_ok_and(|loaded| loaded.status.success()) {
        return true;
    }
    let python = python();
    let why = format!("{} has no python-can or no python-pcapng", python.to_string_lossy());
    skips::skip(why, "tests/interop/README.md says how to install them");
    false
}

/// What the script prints with `input` on its stdin. Its clock is in UTC, as dates in logs here are.
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

/// Who reads and writes which format, by the end of its files.
const REFEREES: [(&str, &str); 3] =
    [("python_can_rows.py", "log"), ("python_can_rows.py", "asc"), ("pcapng_rows.py", "pcapng")];

/// Each referee reads what is written here.
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
        assert_eq!(run(script, "read", &path, ""), rows(&entries), "{end}");
    }
}

/// What each referee writes is read here.
#[test]
fn what_python_writes_is_read_here() {
    if !is_there() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let entries = sample();
    for (script, end) in REFEREES {
        let path = dir.path().join("bus").with_extension(end);
        run(script, "write", &path, &rows(&entries));
        let kept = |entry: &Entry| match (&entry.payload, end) {
            // The length of a remote request is not in the candump logs of python-can.
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
