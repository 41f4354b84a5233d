//! Data written by asammdf give the same findings as the same numbers in CSV.

use super::rig::{file, python_with};
use identification::dataset::Dataset;
use std::path::Path;
use std::process::Command;

/// Imports it as the scripts in `tests/interop` do.
const ASAMMDF: &str =
    "import sys; sys.path.append(sys.prefix + '/apart'); import asammdf, canmatrix";

/// Ways in which the script writes the channels.
const WAYS: [&str; 6] =
    ["plain", "deflated", "transposed", "columns", "columns-deflated", "unfinished"];

fn identified(folder: &Path, package: &str) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hil"));
    let out = format!("{package}-found");
    let output = command.args(["identify", package, "--out", &out]).current_dir(folder).output();
    let output = output.unwrap();
    assert!(output.status.success(), "{package}: {output:?}");
    std::fs::read_to_string(folder.join(out).join("finding.json")).unwrap()
}

/// Checks equality up to rounding; texts are numbered in order of appearance.
fn assert_same(found: &Dataset, expected: &Dataset, way: &str) {
    assert_eq!(found.columns.len(), expected.columns.len());
    assert_eq!(found.run_of_row, expected.run_of_row);
    for (one, other) in found.columns.iter().zip(&expected.columns) {
        assert_eq!((&one.name, one.values.len()), (&other.name, 400), "{way}");
        for (row, (value, expected)) in one.values.iter().zip(&other.values).enumerate() {
            let near = (value - expected).abs() <= 1e-12 * expected.abs().max(1.0);
            assert!(near, "{way}, {}, row {row}: {value}, not {expected}", one.name);
        }
    }
}

#[test]
fn hil_identifies_what_asammdf_wrote() {
    let Some(python) = python_with(ASAMMDF, "asammdf") else { return };
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut command = Command::new(&python);
    command.arg(file("tests/interop/write_measured.py")).arg(folder).env("TZ", "UTC");
    let output = command.output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let expected = dataset::read(&folder.join("csv")).unwrap();
    for way in WAYS {
        let found = dataset::read(&folder.join(way)).unwrap_or_else(|error| panic!("{error}"));
        assert_same(&found, &expected, way);
        let is_told = found.notices.iter().any(|told| told.contains("was not finished"));
        assert_eq!(is_told, way == "unfinished", "{:?}", found.notices);
    }
    assert_eq!(identified(folder, "deflated"), identified(folder, "csv"));
}
