//! Programs on serial lines: each runs as often as said, and sends the same at the same nanosecond.

mod common;

use common::{c, gyro, same_each_time, text};
use lockstep::Program;

#[test]
fn a_controller_in_c_with_poll() {
    let path = c("poll.c");
    let words = [path.as_str(), "/dev/ttyHIL0", "/dev/ttyHIL1"];
    let program = || Program::new(words).serial("/dev/ttyHIL0").serial("/dev/ttyHIL1");
    let events = same_each_time(3, 60, &[gyro(0)], program);
    assert_eq!(events.len(), 60 * 50);
    let text = text(&events, 1);
    // At each moment it has all samples up to then; the last is told in the moment in which the sample comes.
    assert!(text.starts_with("1 2 0.0076 20000000\n") || text.starts_with("1 1 "), "{text:.40}");
    assert!(text.contains("\n3000 "), "the end is told");
}
