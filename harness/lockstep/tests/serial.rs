//! Programs on serial lines: each runs several times, and sends the same at the same nanosecond.

use crate::common::{c, compiled, example, gyro, python_with, same_each_time, source, text};
use lockstep::Program;

#[test]
fn a_controller_in_c_with_poll() {
    let path = c("poll.c");
    let words = [path.as_str(), "/dev/ttyHIL0", "/dev/ttyHIL1"];
    let program = || Program::new(words).serial("/dev/ttyHIL0").serial("/dev/ttyHIL1");
    let events = same_each_time(3, 400, &[gyro(0)], program);
    assert_eq!(events.len(), 400 * 50);
    let text = text(&events, 1);
    // At each instant it has all samples up to then; the last one is reported at the instant at which it arrives.
    assert!(text.starts_with("1 1 0.0092 20000000\n"), "{text:.40}");
    assert!(text.contains("\n20000 "), "the end is told");
}

/// Two serial lines: a gyro, and a base.
fn two(words: &[&str]) -> Program {
    let ports = ["/dev/ttyHIL0", "/dev/ttyHIL1"];
    let words = words.iter().copied().chain(ports);
    Program::new(words).serial(ports[0]).serial(ports[1]).env("PYTHONHASHSEED", "0")
}

#[test]
fn threads_and_a_condition_variable_in_cpp() {
    let path = compiled("g++", "condition.cpp", &["-std=c++17"]);
    let events = same_each_time(3, 50, &[gyro(0)], || two(&[&path]));
    let text = text(&events, 1);
    // First 35 ms without ten samples, then at the tenth.
    assert!(text.starts_with("0 late 3 0.0"), "{text:.60}");
    assert!(text.contains(" told "), "{text:.600}");
}

#[test]
fn threads_of_rust() {
    let path = example("rust_threads");
    let events = same_each_time(3, 50, &[gyro(0)], || two(&[&path]));
    let text = text(&events, 1);
    assert!(text.starts_with("0.0000 1 1 11500000\n0.0092 1 1 13500000\n"), "{text:.80}");
}

#[test]
fn tokio_on_two_threads() {
    let path = example("rust_tokio");
    let events = same_each_time(3, 50, &[gyro(0)], || two(&[&path]));
    let text = text(&events, 1);
    assert!(text.starts_with("0.0000 "), "{text:.80}");
    assert_eq!(text.lines().count(), 2_001, "a line each 25 ms, and one at first");
}

#[test]
fn pyserial() {
    let Some(python) = python_with("serial") else { return };
    let script = source("reader.py");
    let words = [python.as_str(), script.to_str().unwrap()];
    let events = same_each_time(3, 50, &[gyro(0)], || two(&words));
    let text = text(&events, 1);
    assert!(text.starts_with("2 0.0176 0.020000000\n"), "{text:.80}");
    assert_eq!(text.lines().count(), 2_500, "one for two samples");
}
