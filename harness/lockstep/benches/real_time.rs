//! Speed of programs relative to real time: a gyro at 100 Hz and a base at 50 Hz, one program for each way of waiting.
//!
//! `cargo bench -p lockstep`. Each figure is the median of five runs, with best and worst beside it, because a shared
//! machine is noisy. The last column is the time from the start of a program to its first wait, in milliseconds, which
//! each case pays. Programs in Python are skipped if `HIL_TESTS_PYTHON` does not name an interpreter with their
//! packages.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot go on ends")]

#[allow(dead_code, reason = "the tests use the rest")]
#[path = "../tests/common/mod.rs"]
mod common;

use common::{Stream, base, bytes, c, compiled, drive, go, gyro, python_with, secs, source};
use lockstep::Program;
use std::time::Instant;
use wire::device::{Device as _, PortId};
use wire::time::Timestamp;

const RUNS: usize = 5;

#[expect(clippy::disallowed_methods, reason = "a benchmark takes the time of day")]
fn report(name: &str, seconds: i64, streams: &[Stream], program: impl Fn() -> Program) {
    let (mut starts_ms, mut factors) = (Vec::new(), Vec::new());
    for _ in 0..RUNS {
        let began = Instant::now();
        let mut running = program().start().unwrap();
        drive(&mut running, Timestamp::ZERO, &[]);
        starts_ms.push(began.elapsed().as_secs_f64() * 1e3);
        // Work that the program does only once is not measured.
        drive(&mut running, secs(1), &[]);
        let began = Instant::now();
        let events = drive(&mut running, secs(1 + seconds), streams);
        assert!(!events.is_empty(), "{name}: {:?} {}", running.state(), running.last_words());
        factors.push(seconds as f64 / began.elapsed().as_secs_f64());
    }
    factors.sort_by(f64::total_cmp);
    starts_ms.sort_by(f64::total_cmp);
    let (worst, median, best) = (factors[0], factors[RUNS / 2], factors[RUNS - 1]);
    let start_ms = starts_ms[RUNS / 2];
    println!("| {name} | {median:.0} ({best:.0}, {worst:.0}) | {start_ms:.1} |");
}

/// Round trips per second of real time: data is sent to the program and answered, each at the next instant.
#[expect(clippy::disallowed_methods, reason = "a benchmark takes the time of day")]
fn round_trips(name: &str, words: &[&str]) {
    const TRIPS: i64 = 20_000;
    let port = "/dev/ttyHIL0";
    let mut rates: Vec<f64> = (0..RUNS)
        .map(|_| {
            let program = Program::new(words.iter().copied().chain([port])).serial(port);
            let mut running = program.start().unwrap();
            drive(&mut running, Timestamp::ZERO, &[]);
            let (began, said) = (Instant::now(), bytes("a question of 16"));
            for trip in 1..=TRIPS {
                let at = Timestamp::from_nanos(trip * 1_000);
                running.receive(at, PortId(0), &said);
                assert_eq!(running.transmit(at), Some((PortId(0), said)), "{name}");
            }
            TRIPS as f64 / began.elapsed().as_secs_f64()
        })
        .collect();
    rates.sort_by(f64::total_cmp);
    let (worst, median, best) = (rates[0], rates[RUNS / 2], rates[RUNS - 1]);
    println!("| {name} | {median:.0} ({best:.0}, {worst:.0}) |");
}

/// An echo in Python, without packages.
const ECHO: &str = "
import os, sys, tty
port = os.open(sys.argv[1], os.O_RDWR)
tty.setraw(port)
while True:
    os.write(port, os.read(port, 64))
";

fn main() {
    // `cargo test --benches` only checks that it starts.
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    println!("| program | times real time | start, ms |\n|---|---|---|");
    let two = || ["/dev/ttyHIL0", "/dev/ttyHIL1"];
    let serial = |words: &[&str]| {
        Program::new(words.iter().copied().chain(two())).serial(two()[0]).serial(two()[1])
    };
    let poll = c("poll.c");
    report(
        "C with `poll`: a gyro at 100 Hz and a base at 50 Hz on serial lines (aim 300)",
        300,
        &[gyro(0)],
        || serial(&[&poll]),
    );
    let without_library = compiled("gcc", "poll.c", &["-static"]);
    report("the same program, linked statically: by the tracer (aim 300)", 300, &[gyro(0)], || {
        serial(&[&without_library])
    });
    if let Some(controller) = go("serial.go") {
        report("Go with goroutines on the same lines: by the tracer", 60, &[gyro(0)], || {
            serial(&[&controller])
        });
    }
    if let Some(node) = go("can.go") {
        let program =
            || Program::new([node.as_str(), "can0", two()[0]]).can("can0").serial(two()[0]);
        report("Go on a raw CAN socket, 50 Hz: by the tracer", 60, &[base(0)], program);
    }
    let python = |script: &str| {
        let script = source(script).to_str().unwrap().to_owned();
        move |interpreter: &str| vec![interpreter.to_owned(), script.clone()]
    };
    if let Some(interpreter) = python_with("serial") {
        let words = python("reader.py")(&interpreter);
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        report("Python with pyserial, 100 Hz (aim 100)", 120, &[gyro(0)], || {
            serial(&words).env("PYTHONHASHSEED", "0")
        });
    }
    if let Some(interpreter) = python_with("can") {
        let words = python("notifier.py")(&interpreter);
        let program = || Program::new(words.clone()).can("can0").env("PYTHONHASHSEED", "0");
        report(
            "Python with python-can and its `Notifier`, 50 Hz (aim 100)",
            120,
            &[base(0)],
            program,
        );
    }
    println!("\n| program | round trips a second |\n|---|---|");
    round_trips("C, read and write", &[&c("echo.c")]);
    round_trips("static C", &[&compiled("gcc", "echo.c", &["-static"])]);
    let interpreter = common::python();
    round_trips("Python, os.read and os.write", &[interpreter.to_str().unwrap(), "-c", ECHO]);
}
