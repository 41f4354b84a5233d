//! A small rig: streams timed by the bench clock, and everything that a program sends.

use lockstep::verify::{Event, compare};
use lockstep::{Lockstep, Program};
use std::ffi::OsString;
use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;
use wire::can::{CanFrame, StandardId};
use wire::device::{Device as _, PortId, Transmit};
use wire::packet::Packet;
use wire::time::{Span, Timestamp};

/// A periodic input.
pub struct Stream {
    pub port: PortId,
    pub period: Span,
    pub what: fn(i64) -> Transmit,
}

/// A gyro at 100 Hz: one line per sample.
pub fn gyro(port: u8) -> Stream {
    let what = |k: i64| bytes(&format!("{:.4}\n", (k * 7_919 % 1_000) as f64 / 1_000.0));
    Stream { port: PortId(port), period: Span::from_millis(10), what }
}

/// A base at 50 Hz, on CAN.
pub fn base(port: u8) -> Stream {
    let what = |k: i64| frame(0x181, &(k as u32).to_be_bytes());
    Stream { port: PortId(port), period: Span::from_millis(20), what }
}

pub fn bytes(text: &str) -> Transmit {
    Transmit::Bytes(Packet::from_slice(text.as_bytes()).unwrap())
}

pub fn frame(id: u16, data: &[u8]) -> Transmit {
    Transmit::Frame(CanFrame::new(StandardId::new(id).unwrap(), data).unwrap())
}

/// Advances time until `end`, or until the program has ended.
pub fn drive(running: &mut Lockstep, end: Timestamp, streams: &[Stream]) -> Vec<Event> {
    let mut events = Vec::new();
    let mut counts = vec![1; streams.len()];
    while running.ended().is_none() {
        let due = |(number, stream): (usize, &Stream)| {
            (Timestamp::ZERO + stream.period * counts[number], number)
        };
        let (arrival, number) =
            streams.iter().enumerate().map(due).min().unwrap_or((Timestamp::MAX, 0));
        let wakeup = running.next_wakeup();
        let at = arrival.min(wakeup);
        if at > end {
            break;
        }
        if wakeup <= arrival {
            running.wake(at);
        } else {
            running.receive(at, streams[number].port, &(streams[number].what)(counts[number]));
            counts[number] += 1;
        }
        while let Some((port, what)) = running.transmit(at) {
            events.push(Event { at, port, what });
        }
    }
    events
}

pub fn secs(seconds: i64) -> Timestamp {
    Timestamp::ZERO + Span::from_secs(seconds)
}

/// Runs a program several times, the last times with two busy threads beside it, and returns what it sent, which must
/// be the same each time.
pub fn same_each_time(
    runs: usize,
    seconds: i64,
    streams: &[Stream],
    program: impl Fn() -> Program,
) -> Vec<Event> {
    let mut first = None;
    for run in 0..runs {
        let _busy = (run > 0).then(Busy::start);
        let mut running = program().start().unwrap();
        let events = drive(&mut running, secs(seconds), streams);
        let place = format!("run {run}: {:?} {}", running.state(), running.last_words());
        let first = first.get_or_insert_with(|| events.clone());
        if let Some(difference) = compare(first, &events) {
            panic!("{place}: {difference}");
        }
        assert!(!events.is_empty(), "{place}: nothing was sent");
        assert_eq!(running.lost(), 0, "{place}");
        let left = running.pids();
        drop(running);
        none_left(&left);
    }
    first.unwrap_or_default()
}

/// Two threads that use all the processor time they get.
pub struct Busy(Arc<AtomicBool>, Vec<thread::JoinHandle<()>>);

impl Busy {
    pub fn start() -> Self {
        let ends = Arc::new(AtomicBool::new(false));
        let spin = |ends: Arc<AtomicBool>| move || while !ends.load(Ordering::Relaxed) {};
        let threads = (0..2).map(|_| thread::spawn(spin(Arc::clone(&ends)))).collect();
        Self(ends, threads)
    }
}

impl Drop for Busy {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
        for thread in self.1.drain(..) {
            thread.join().unwrap();
        }
    }
}

/// Panics if one of the processes still runs.
pub fn none_left(pids: &[i32]) {
    for pid in pids {
        let text = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
        // A zombie counts as gone.
        let runs =
            text.rsplit(") ").next().is_some_and(|rest| !rest.is_empty() && !rest.starts_with('Z'));
        assert!(!runs, "process {pid} is left: {text}");
    }
}

/// Process ids of all processes whose executable is the one at `path`.
pub fn processes_of(path: &str) -> Vec<i32> {
    let numbers = std::fs::read_dir("/proc").unwrap().filter_map(|entry| {
        let entry = entry.unwrap();
        let number = entry.file_name().to_str()?.parse().ok()?;
        let executable = std::fs::read_link(entry.path().join("exe")).ok()?;
        (executable.to_str()? == path).then_some(number)
    });
    numbers.collect()
}

/// Panics if a process of that program is left.
pub fn none_left_of(path: &str) {
    // The kernel needs some time, and more on a busy machine: a process that was killed must run to end.
    for _ in 0..3_000 {
        if processes_of(path).is_empty() {
            return;
        }
        thread::park_timeout(Duration::from_millis(20));
    }
    panic!("{:?} of {path} are left", processes_of(path));
}

/// A program that waits long, with the rights of another user; `None`, with a message, if only root could make one.
pub fn with_others_rights(arguments: &[&str]) -> Option<String> {
    let path = compiled("gcc", "idle.c", arguments);
    if std::os::unix::fs::chown(&path, Some(1), None).is_err() {
        skips::skip("no right to give a file away", "run it as root");
        return None;
    }
    std::fs::set_permissions(&path, Permissions::from_mode(0o4755)).unwrap();
    Some(path)
}

pub fn source(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/programs").join(name)
}

/// Compiles one of the programs; returns its path.
pub fn compiled(compiler: &str, name: &str, arguments: &[&str]) -> String {
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let number = COUNT.fetch_add(1, Ordering::Relaxed);
    let place = format!("{name}-{}-{number}", std::process::id());
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(place);
    let status = Command::new(compiler)
        .args(["-O1", "-o"])
        .arg(&path)
        .arg(source(name))
        .args(arguments)
        .arg("-pthread")
        .status()
        .unwrap();
    assert!(status.success(), "{name} does not compile");
    path.to_str().unwrap().to_owned()
}

pub fn c(name: &str) -> String {
    compiled("gcc", name, &[])
}

/// One of the programs in Go, without the C library; `None`, with a message, if there is no compiler.
pub fn go(name: &str) -> Option<String> {
    go_with(name, "0")
}

/// The same with `CGO_ENABLED` of this value: "1" is the default of Go where there is a C compiler.
pub fn go_with(name: &str, cgo: &str) -> Option<String> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let path = folder.join(format!("{name}-{cgo}-{}", std::process::id()));
    let built = Command::new("go")
        .args(["build", "-o"])
        .arg(&path)
        .arg(source(name))
        .env("CGO_ENABLED", cgo)
        .env("GO111MODULE", "off")
        .env("GOCACHE", folder.join("go"))
        .status();
    match built {
        Ok(status) => assert!(status.success(), "{name} does not compile"),
        Err(cause) => {
            let why = format!("no Go: {cause}");
            skips::skip_unless("HIL_TESTS_NEED_GO", why, "apt install golang-go");
            return None;
        }
    }
    Some(path.to_str().unwrap().to_owned())
}

pub fn python() -> OsString {
    std::env::var_os("HIL_TESTS_PYTHON").unwrap_or_else(|| "python3".into())
}

/// Python with these packages; `None`, with a message, if it is missing.
pub fn python_with(packages: &str) -> Option<String> {
    let loaded = Command::new(python()).args(["-c", &format!("import {packages}")]).output();
    if loaded.is_ok_and(|loaded| loaded.status.success()) {
        return python().into_string().ok();
    }
    let why = format!("{} has no {packages}", python().to_string_lossy());
    let how = "tests/interop/README.md says how to set HIL_TESTS_PYTHON";
    skips::skip_unless("HIL_TESTS_NEED_PYTHON", why, how);
    None
}

/// Whether a tool is installed; prints a message if not.
pub fn has_tool(name: &str) -> bool {
    let found = Command::new("which").arg(name).output().is_ok_and(|out| out.status.success());
    if !found {
        skips::skip_unless(skips::CAN_REQUIRED, format!("no {name}"), "apt install can-utils");
    }
    found
}

/// Data sent at a port, as text.
pub fn text(events: &[Event], port: u8) -> String {
    let mut all = Vec::new();
    for event in events.iter().filter(|event| event.port == PortId(port)) {
        if let Transmit::Bytes(packet) = &event.what {
            all.extend_from_slice(packet.as_slice());
        }
    }
    String::from_utf8(all).unwrap()
}

/// One of the crate's examples. Cargo builds them with all tests of a crate, but not with a single test.
pub fn example(name: &str) -> String {
    static BUILT: Mutex<()> = Mutex::new(());
    let _one_at_a_time = BUILT.lock();
    let own = std::env::current_exe().unwrap();
    let path = own.parent().and_then(Path::parent).unwrap().join("examples").join(name);
    if !path.is_file() {
        let mut build = Command::new(env!("CARGO"));
        build.args(["build", "--offline", "--package", "lockstep", "--example", name]);
        if !cfg!(debug_assertions) {
            build.arg("--release");
        }
        assert!(build.status().unwrap().success(), "{name} does not compile");
    }
    path.to_str().unwrap().to_owned()
}
