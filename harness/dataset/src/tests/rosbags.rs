//! Bags written by rosbags and by MCAP's own package have the same numbers as CSV.

use crate::read;
use std::path::Path;
use std::process::Command;

/// If set, a missing package is a failure.
const PYTHON_REQUIRED: &str = "HIL_TESTS_NEED_PYTHON";

const BAGS: [&str; 9] = [
    "bag-none",
    "bag-bz2",
    "bag-lz4",
    "mcap-none",
    "mcap-zstd",
    "mcap-lz4",
    "db3-none",
    "db3-zstd",
    "db3-humble",
];

#[test]
fn bags_of_other_programs_have_the_numbers_of_the_table() {
    let python = std::env::var_os("HIL_TESTS_PYTHON").unwrap_or_else(|| "python3".into());
    let imports = Command::new(&python).args(["-c", "import rosbags, mcap, numpy"]).output();
    if !imports.is_ok_and(|output| output.status.success()) {
        let why = format!("{} has no rosbags and mcap", python.display());
        skips::skip_unless(PYTHON_REQUIRED, why, "tests/interop/README.md says how to install it");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/interop/write_rosbags.py");
    let output = Command::new(&python).arg(script).arg(folder.path()).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let expected = read(&folder.path().join("csv")).unwrap();
    assert_eq!(expected.rows(), 400);
    for bag in BAGS {
        let found = read(&folder.path().join(bag)).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(found.columns.len(), expected.columns.len());
        for (one, other) in found.columns.iter().zip(&expected.columns) {
            assert_eq!((&one.name, one.values.len()), (&other.name, 400), "{bag}");
            for (row, (value, expected)) in one.values.iter().zip(&other.values).enumerate() {
                let is_same = value == expected || value.is_nan() && expected.is_nan();
                assert!(is_same, "{bag}, {}, row {row}: {value}, not {expected}", one.name);
            }
        }
        let told = found.notices.iter().any(|told| told.contains("not finished"));
        assert!(!told, "{bag}: {:?}", found.notices);
    }
}
