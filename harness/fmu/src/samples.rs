//! FMUs for tests: an oven in C, by the functions of the standard alone.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::path::Path;
use std::process::Command;

const SOURCE: &str = include_str!("../samples/oven.c");

/// The descriptions of the oven, for FMI 2.0 and 3.0.
pub const DESCRIPTIONS: [&str; 2] =
    [include_str!("../samples/oven2.xml"), include_str!("../samples/oven3.xml")];

/// The path of the library in the FMU, for FMI 2.0 and 3.0.
pub const LIBRARIES: [&str; 2] = ["binaries/linux64/oven.so", "binaries/x86_64-linux/oven.so"];

/// The library of the oven.
///
/// # Panics
/// Without a C compiler.
pub fn library(version: usize) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let (source, library) = (folder.path().join("oven.c"), folder.path().join("oven.so"));
    std::fs::write(&source, SOURCE).unwrap();
    let mut compiler = Command::new("cc");
    // The same numbers by any compiler.
    compiler.args(["-shared", "-fPIC", "-O1", "-ffp-contract=off"]);
    compiler.args((version == 3).then_some("-DFMI3"));
    let built = compiler.arg(&source).arg("-o").arg(&library).status().unwrap();
    assert!(built.success());
    std::fs::read(library).unwrap()
}

/// Writes the oven as an FMU of version 2 or 3, with a changed description.
///
/// # Panics
/// When it cannot be written.
pub fn oven(path: &Path, version: usize, change: impl FnOnce(&str) -> String) {
    let library = library(version);
    let description = change(DESCRIPTIONS[version - 2]);
    let files = [
        ("modelDescription.xml", description.as_bytes()),
        (LIBRARIES[version - 2], &library),
        ("resources/readme.txt", b"An oven."),
    ];
    crate::write(path, files).unwrap();
}
