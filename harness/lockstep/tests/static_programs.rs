//! Programs that load no C library: the tracer runs them, by the same contract as the shim.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod common;

use common::{c, compiled, drive, gyro, same_each_time, secs, text};
use lockstep::Program;

/// Two serial lines: a gyro, and a base.
fn two(words: &[&str]) -> Program {
    let ports = ["/dev/ttyHIL0", "/dev/ttyHIL1"];
    let words = words.iter().copied().chain(ports);
    Program::new(words).serial(ports[0]).serial(ports[1])
}

#[test]
fn a_static_program_sends_what_the_dynamic_one_sends_at_the_same_nanoseconds() {
    let (with_tracer, with_shim) = (compiled("gcc", "poll.c", &["-static"]), c("poll.c"));
    let events = same_each_time(3, 100, &[gyro(0)], || two(&[&with_tracer]));
    assert_eq!(events.len(), 100 * 50);
    let mut running = two(&[&with_shim]).start().unwrap();
    assert_eq!(events, drive(&mut running, secs(100), &[gyro(0)]));
    assert!(text(&events, 1).starts_with("1 1 0.0092 20000000\n"));
}
