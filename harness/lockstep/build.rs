//! Builds what is embedded in the crate: the shim, a shared library in C that is preloaded into programs, and the
//! tracer, a program in C that runs programs without a dynamic loader.

use std::path::{Path, PathBuf};
use std::{env, fs};

/// Sources of the shim that the tracer shares.
const SHARED: [&str; 14] = [
    "can_bcm.c",
    "can_interface.c",
    "can_links.c",
    "can_message.c",
    "can_socket.c",
    "descriptors.c",
    "link.c",
    "moments.c",
    "serial.c",
    "serial_port.c",
    "stuck.c",
    "timers.c",
    "turns.c",
    "wait_fds.c",
];

fn sources(folder: &str) -> Vec<PathBuf> {
    println!("cargo::rerun-if-changed={folder}");
    let mut sources: Vec<PathBuf> = fs::read_dir(folder)
        .expect("a folder of sources")
        .map(|entry| entry.expect("a source").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "c"))
        .collect();
    sources.sort();
    sources
}

#[expect(
    deprecated,
    reason = "without static_flag, a harness that is linked statically asks for -static here, too"
)]
fn compile(name: &str, kind: &[&str], sources: &[PathBuf]) {
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo says where")).join(name);
    // The shim is for the GNU C library, whatever the harness itself is linked with.
    let target = env::var("TARGET").expect("cargo says for what").replace("-musl", "-gnu");
    let mut build = cc::Build::new();
    // A library is never static, and neither is what it is loaded into, even if the harness is.
    build.target(&target).opt_level(2).pic(true).static_flag(false).warnings(false);
    let status = build
        .get_compiler()
        .to_command()
        .args(kind)
        .args(["-std=gnu11", "-fvisibility=hidden", "-Wall", "-Wextra", "-Werror"])
        .args(["-Wno-nonnull-compare", "-Wno-unknown-warning-option", "-fno-strict-aliasing"])
        .arg("-o")
        .arg(&out)
        .args(sources)
        .args(["-ldl", "-lpthread"])
        .status()
        .expect("a C compiler");
    assert!(status.success(), "{name} does not compile");
}

fn main() {
    let shim = sources("shim");
    compile("shim.so", &["-shared"], &shim);
    let mut tracer = sources("tracer");
    if env::var("CARGO_CFG_TARGET_ARCH").is_ok_and(|machine| machine == "x86_64") {
        tracer.extend(SHARED.iter().map(|name| Path::new("shim").join(name)));
        compile("tracer", &[], &tracer);
    } else {
        let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo says where")).join("tracer");
        fs::write(out, []).expect("room for an empty file");
    }
}
