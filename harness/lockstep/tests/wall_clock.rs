//! A wall clock that is set: no other clock and no relative wait notices.

use crate::common::{c, compiled, drive, secs, text};
use lockstep::Program;
use wire::time::{Span, Timestamp};

/// The lines that the program sends until 12 s, when its wall clock is set after 1.05 s.
fn lines(path: &str, by_s: i64) -> Vec<String> {
    let program = Program::new([path, "/dev/ttyHIL0"]).serial("/dev/ttyHIL0");
    let mut running = program.start().unwrap();
    let at = Timestamp::ZERO + Span::from_millis(1_050);
    let mut events = drive(&mut running, at, &[]);
    running.set_wall_clock(at, Span::from_secs(by_s));
    events.extend(drive(&mut running, secs(12), &[]));
    text(&events, 0).lines().map(str::to_owned).collect()
}

#[test]
fn a_step_of_the_wall_clock_moves_what_waits_for_it_and_nothing_else() {
    for path in [c("wall_clock.c"), compiled("gcc", "wall_clock.c", &["-static"])] {
        for by_s in [0, 2, 5, -4] {
            let lines = lines(&path, by_s);
            let step_ms = by_s * 1_000;
            let ticks: Vec<&String> =
                lines.iter().filter(|line| line.starts_with("tick")).collect();
            assert_eq!(ticks.len(), 120, "{path} {by_s}: {lines:?}");
            assert_eq!(*ticks[9], "tick 1000 1000");
            assert_eq!(*ticks[10], format!("tick 1100 {}", 1_100 + step_ms));
            for (what, due_ms) in [("sleep", 3_000), ("semaphore", 4_000), ("timer", 5_000)] {
                // As soon as the wall clock shows its time, or has passed it.
                let at_ms = (due_ms - step_ms).max(1_050);
                let expected = format!("{what} {at_ms} {}", at_ms + step_ms);
                assert!(lines.contains(&expected), "{path} {by_s}: no {expected} in {lines:?}");
            }
        }
    }
}
