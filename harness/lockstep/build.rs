//! Builds the shim: a shared library in C that is embedded in the crate and preloaded into programs.

use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() {
    let folder = Path::new("shim");
    println!("cargo::rerun-if-changed=shim");
    let mut sources: Vec<PathBuf> = fs::read_dir(folder)
        .expect("the folder of the shim")
        .map(|entry| entry.expect("a file of the shim").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "c"))
        .collect();
    sources.sort();
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo says where")).join("shim.so");
    // It is loaded into programs of the GNU C library, whatever the harness itself is linked with.
    let target = env::var("TARGET").expect("cargo says for what").replace("-musl", "-gnu");
    let mut build = cc::Build::new();
    build.target(&target).opt_level(2).pic(true).warnings(false);
    let compiler = build.get_compiler();
    let status = compiler
        .to_command()
        .args(["-shared", "-std=gnu11", "-fvisibility=hidden", "-Wall", "-Wextra", "-Werror"])
        .args(["-Wno-nonnull-compare", "-Wno-unknown-warning-option", "-fno-strict-aliasing"])
        .arg("-o")
        .arg(&out)
        .args(&sources)
        .args(["-ldl", "-lpthread"])
        .status()
        .expect("a C compiler");
    assert!(status.success(), "the shim does not compile");
}
