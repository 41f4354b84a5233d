//! An hour of bench time, twenty times, on a busy machine: each program sends the same at the same nanosecond.
//!
//! `cargo test -p lockstep --release --test programs -- hour:: --ignored --nocapture --test-threads 1` prints a row for each.
//! `HIL_TESTS_HOURS` sets another number of runs. Programs in Python need an interpreter with their packages
//! (`HIL_TESTS_PYTHON`).

use crate::common::{
    Stream, base, c, compiled, example, go, gyro, python_with, same_each_time, secs, source,
};
use lockstep::Program;
use std::time::Instant;

const SECONDS: i64 = 3_600;

fn runs() -> usize {
    std::env::var("HIL_TESTS_HOURS").map_or(20, |text| text.parse().expect("a number of runs"))
}

#[expect(clippy::disallowed_methods, reason = "how long it takes is what is asked")]
fn an_hour(name: &str, streams: &[Stream], program: impl Fn() -> Program) {
    let (runs, began) = (runs(), Instant::now());
    let events = same_each_time(runs, SECONDS, streams, program);
    let took_s = began.elapsed().as_secs_f64();
    let factor = runs as f64 * SECONDS as f64 / took_s;
    println!("| {name} | {runs} | {} | {took_s:.0} s | {factor:.0} |", events.len());
    // It has not stalled before the end.
    let last = events.last().unwrap().at;
    assert!(last >= secs(SECONDS - 1), "{name}: nothing after {} s", last.as_secs_f64());
}

fn two(words: &[&str]) -> Program {
    let ports = ["/dev/ttyHIL0", "/dev/ttyHIL1"];
    let words = words.iter().copied().chain(ports);
    Program::new(words).serial(ports[0]).serial(ports[1]).env("PYTHONHASHSEED", "0")
}

#[test]
#[ignore = "minutes"]
fn c_with_poll() {
    let path = c("poll.c");
    an_hour("C, poll", &[gyro(0)], || two(&[&path]));
}

#[test]
#[ignore = "minutes"]
fn static_c_with_poll() {
    let path = compiled("gcc", "poll.c", &["-static"]);
    an_hour("static C, poll", &[gyro(0)], || two(&[&path]));
}

#[test]
#[ignore = "minutes"]
fn go_with_goroutines() {
    let Some(path) = go("serial.go") else { return };
    an_hour("Go, goroutines", &[gyro(0)], || two(&[&path]));
}

#[test]
#[ignore = "minutes"]
fn go_with_a_raw_can_socket() {
    let Some(path) = go("can.go") else { return };
    let words = [path.as_str(), "can0", "/dev/ttyHIL0"];
    let program = || Program::new(words).can("can0").serial("/dev/ttyHIL0");
    an_hour("Go, CAN", &[base(0)], program);
}

#[test]
#[ignore = "minutes"]
fn cpp_with_threads_and_a_condition_variable() {
    let path = compiled("g++", "condition.cpp", &["-std=c++17"]);
    an_hour("C++, std::thread", &[gyro(0)], || two(&[&path]));
}

#[test]
#[ignore = "minutes"]
fn rust_with_tokio() {
    let path = example("rust_tokio");
    an_hour("Rust, tokio", &[gyro(0)], || two(&[&path]));
}

#[test]
#[ignore = "minutes"]
fn python_with_pyserial() {
    let Some(python) = python_with("serial") else { return };
    let script = source("reader.py");
    an_hour("Python, pyserial", &[gyro(0)], || two(&[&python, script.to_str().unwrap()]));
}

fn python_can(name: &str, script: &str) {
    let Some(python) = python_with("can") else { return };
    let script = source(script);
    let words = [python.as_str(), script.to_str().unwrap()];
    let program = || Program::new(words).can("can0").env("PYTHONHASHSEED", "0");
    an_hour(&format!("Python, python-can, {name}"), &[base(0)], program);
}

#[test]
#[ignore = "minutes"]
fn python_with_threads() {
    python_can("threads", "notifier.py");
}

#[test]
#[ignore = "minutes"]
fn python_with_asyncio() {
    python_can("asyncio", "asynchronous.py");
}
