//! The shim is portable: it compiles for aarch64 if there is a compiler for that.

use std::path::Path;
use std::process::Command;

const COMPILER: &str = "aarch64-linux-gnu-gcc";

#[test]
fn the_shim_compiles_for_aarch64() {
    if Command::new(COMPILER).arg("--version").output().is_err() {
        return skips::skip(format!("no {COMPILER}"), "apt install gcc-aarch64-linux-gnu");
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("shim");
    let files = folder.read_dir().unwrap().map(|entry| entry.unwrap().path());
    let sources = files.filter(|path| path.extension().is_some_and(|extension| extension == "c"));
    let shim = tempfile::tempdir().unwrap();
    let compiled = Command::new(COMPILER)
        .args([
            "-shared",
            "-fPIC",
            "-O2",
            "-std=gnu11",
            "-fvisibility=hidden",
            "-fno-strict-aliasing",
        ])
        .args([
            "-Wall",
            "-Wextra",
            "-Werror",
            "-Wno-nonnull-compare",
            "-Wno-unknown-warning-option",
        ])
        // Detects symbols that only the loader would miss.
        .arg("-Wl,--no-undefined")
        .arg("-o")
        .arg(shim.path().join("shim.so"))
        .args(sources)
        .args(["-ldl", "-lpthread"])
        .status();
    assert!(compiled.unwrap().success());
}
