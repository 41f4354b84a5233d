//! Readings that are NaN or infinite.

use super::{at, formula};
use crate::Monitor;

const SPEED: usize = 3;
const COUNT: usize = 6;

/// When a reading first keeps the formula from being judged.
fn since(text: &str, updates: &[(i64, usize, f64)], end: i64) -> Option<i64> {
    let mut monitor = Monitor::new(formula(text));
    for (time, signal, value) in updates {
        monitor.update(at(*time), &[(*signal, *value)]);
    }
    monitor.finish(at(end)).no_number.map(|found| found.at.as_nanos())
}

#[test]
fn a_reading_that_is_not_finite_is_found_where_the_formula_depends_on_it() {
    let readings = [(0, COUNT, 1.0), (10, COUNT, f64::NAN), (20, COUNT, 1.0)];
    for text in ["Count < 5", "not (Count > 5)", "-5 < Count < 5", "Count > 5 -> Count == 7"] {
        assert_eq!(since(text, &readings, 30), Some(10), "{text}");
    }
    assert_eq!(since("within 3 ns: Count == 1", &readings, 30), Some(10));
    assert_eq!(since("within 10 ns: Count == 1", &readings, 30), None, "it comes in time");
    assert_eq!(since("for 3 ns: Count == 1", &readings, 30), Some(7));
    assert_eq!(since("for 3 ns: Count == 2", &readings, 30), Some(10), "before, it is false");
    assert_eq!(since("once: Count == 1", &readings, 30), None);
    assert_eq!(since("Count < 5", &[(0, COUNT, f64::NAN)], 30), Some(0), "from the start");
    let infinite = [(0, COUNT, 1.0), (10, COUNT, f64::INFINITY)];
    assert_eq!(since("Count < 5", &infinite, 30), None, "that is false");
    assert_eq!(since("Count - Count < 5", &infinite, 30), Some(10));
}

#[test]
fn what_another_signal_decides_does_not_depend_on_the_reading() {
    let text = "Speed > 3 -> Count == 1";
    let readings = [
        (0, SPEED, 0.0),
        (0, COUNT, 1.0),
        (10, COUNT, f64::NAN),
        (15, SPEED, 5.0),
        (20, COUNT, 1.0),
    ];
    assert_eq!(since(text, &readings, 30), Some(15));
    assert_eq!(since(text, &readings[..3], 30), None);
    // A signal without a value, not the reading, keeps it from being judged.
    assert_eq!(since("Speed > 3 or Count == 1", &[(0, COUNT, f64::NAN)], 30), None);
    // What follows the end of the run is open.
    assert_eq!(since("within 20 ns: Count == 2", &readings[1..3], 25), Some(0));
    assert_eq!(since("within 20 ns: Count == 2", &readings[1..3], 15), None);
}

#[test]
fn the_readings_are_told_with_the_moment() {
    let mut monitor = Monitor::new(formula("Speed < 3 or Count < 5"));
    monitor.update(at(0), &[(SPEED, 1.0), (COUNT, 1.0)]);
    monitor.update(at(10), &[(COUNT, f64::NEG_INFINITY)]);
    assert_eq!(monitor.verdict().no_number, None);
    monitor.update(at(20), &[(COUNT, f64::NAN), (SPEED, f64::NAN)]);
    monitor.advance(at(30));
    let found = monitor.verdict().no_number.clone().expect("neither decides");
    assert_eq!(found.at, at(20));
    let names: Vec<&str> = found.readings.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["Count", "Speed"]);
}
