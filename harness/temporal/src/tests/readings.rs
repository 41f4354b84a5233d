//! Parsing: precedence, units, names.

use super::{at, formula, read};
use crate::{Evaluator, Formula};

/// The truth of a formula without time operators at these values of the signals.
fn holds(text: &str) -> Option<bool> {
    let values = [4.25, 2_000.0, 3.0, 72.0, 20.0, 25.0, -2.0, 7.0];
    let mut evaluator = Evaluator::new(&formula(text));
    let values: Vec<_> = values.into_iter().enumerate().collect();
    evaluator.update(at(0), &values);
    evaluator.finish(at(0));
    evaluator.take().and_then(|stretch| stretch.truth.holds())
}

fn same(left: &str, right: &str) {
    let (left, right): (Formula, Formula) = (formula(left), formula(right));
    assert_eq!(left.condition, right.condition, "{} and {}", left.text(), right.text());
}

#[test]
fn operators_bind_as_written() {
    let (a, b, c) = ("Speed > 1", "Count > 2", "Flow > 3");
    same(&format!("{a} or {b} and {c}"), &format!("{a} or ({b} and {c})"));
    same(&format!("{a} -> {b} -> {c}"), &format!("{a} -> ({b} -> {c})"));
    same(&format!("{a} or {b} -> {c}"), &format!("({a} or {b}) -> {c}"));
    same(&format!("not {a} and {b}"), &format!("(not ({a})) and {b}"));
    same(&format!("!{a} && {b} || {c}"), &format!("not {a} and {b} or {c}"));
    same(&format!("not not {a}"), a);
    same(&format!("{a} until [0, 1 s] {b} -> {c}"), &format!("({a} until [0, 1 s] {b}) -> {c}"));
    // A colon extends far to the right.
    same(&format!("within 1 s: {a} and {b} or {c}"), &format!("within 1 s: ({a} and {b} or {c})"));
    same(&format!("{a} and for 1 s: {b} or {c}"), &format!("{a} and (for 1 s: ({b} or {c}))"));
    same(&format!("not within 1 s: {a} and {b}"), &format!("not (within 1 s: ({a} and {b}))"));
    same(&format!("{a} -> within 1 s: {b}"), &format!("({a}) -> (within 1 s: {b})"));
    same(&format!("within 1 s: {a}"), &format!("eventually [0, 1000 ms]: {a}"));
    same(&format!("for 1 min: {a}"), &format!("always [0, 60 s]: {a}"));
    same(&format!("within 1.5 us: {a}"), &format!("within 1500ns: {a}"));
    same(&format!("within 0.1 s: {a}"), &format!("within 100 ms: {a}"));
    same("falls(Speed > 1)", "rises(not Speed > 1)");
    same("1 < Speed <= 2", "1 < Speed and Speed <= 2");
}

#[test]
fn arithmetic_is_that_of_the_school() {
    for text in [
        "Count + 2 * 3 == 4",
        "7 - 2 - Count == 7",
        "-Count * 3 == 6",
        "8 / 4 / Count == -1",
        "abs(Count - 1) == 3",
        "min(Count, 1, 5) == -2",
        "max(Count, 1, 5) == 5",
        "min(max(Count, 0), 1) == 0",
        "Count == -2 +- 0",
        "Count == -2.5 ± 0.5",
        "not Count == -2.5 +- 0.4",
        "Count != -2.5 +- 0.4",
        "not Count != -2.5 +- 0.5",
        "-3 < Count < -1",
        "-1 > Count >= -2",
        "2 * (Count + 1) == -2",
        "-Count == 2",
        "Count / 0 < -1e300",
    ] {
        assert_eq!(holds(text), Some(true), "{text}");
    }
    assert_eq!(holds("0 / 0 * Count > 1"), None);
    assert_eq!(holds("max(Count, 0 / 0) > 1"), None);
}

#[test]
fn strictness_decides_at_the_border() {
    for (text, expected) in [
        ("Count >= -2", true),
        ("Count > -2", false),
        ("Count <= -2", true),
        ("Count < -2", false),
        ("Count == -2", true),
        ("Count != -2", false),
    ] {
        assert_eq!(holds(text), Some(expected), "{text}");
        assert_eq!(holds(&format!("not {text}")), Some(!expected), "not {text}");
    }
}

/// Three counts of 0.1 are 0.30000000000000004.
#[test]
fn rounding_decides_nothing() {
    for text in [
        "0.1 * (Count + 5) <= 0.3",
        "0.1 * (Count + 5) == 0.3",
        "not 0.1 * (Count + 5) > 0.3",
        "5 - 0.1 * (Count + 3) == 5 +- 0.1",
        "0.1 * (Count + 5) < 0.3000000000001",
    ] {
        assert_eq!(holds(text), Some(true), "{text}");
    }
}

#[test]
fn units_are_converted() {
    for text in [
        "cells.VoltageMax == 4250 mV",
        "4.25 V == cells.VoltageMax",
        "cells.VoltageMax == 4.25",
        "cells.Current == 2 A",
        "cells.Current == 2000",
        "Speed == 20 m/s",
        "Speed == 72 kph",
        "Speed == Wheel.Speed",
        "Wheel.Speed + Speed == 40",
        "Temperature == 25 °C",
        "Temperature == 25degC",
        "Flow == 7 drops",
        "cells.VoltageMax * cells.Current == 8.5 W",
        "Speed / Wheel.Speed == 3.6",
        "cells.VoltageMax == 4 V +- 300 mV",
        "4 V == cells.VoltageMax +- 300 mV",
        "4200 mV < cells.VoltageMax < 4.3 V",
        "cells.VoltageMax == 8.5 V/2",
        "cells.VoltageMax == 2.125 V*2",
        "cells.VoltageMax * cells.Current == 8.5 A*V",
        "84.9 V·m/sec < Speed * cells.VoltageMax < 85.1 m*V/s",
        "0.049 sec/m < 1 / Speed < 0.051 s/m",
        "0.23 1/V < 1 / cells.VoltageMax < 0.24 1/V",
        "max(Speed, Wheel.Speed) == 72",
        "cells.VoltageMax - 250 mV == 4 V",
        "abs(-cells.Current) == 0.002 kA",
    ] {
        match read(text) {
            Ok(_) => assert_eq!(holds(text), Some(true), "{text}"),
            Err(mistake) => panic!("{text}: {mistake:?}"),
        }
    }
}

#[test]
fn names_stand_for_their_values() {
    assert_eq!(holds("manager.State == \"Ready\""), Some(true));
    assert_eq!(holds("\"Idle\" != manager.State"), Some(true));
    assert_eq!(holds("manager.State == \"Idle\""), Some(false));
}

#[test]
fn a_formula_tells_what_it_reads_and_how_far_it_looks() {
    let text = "Speed > 3 -> within 1 s: (for 500 ms: Count > Speed) and historically: Flow > 1";
    let formula = formula(text);
    let names: Vec<_> =
        formula.signals().iter().map(|used| (used.name.as_str(), used.index)).collect();
    assert_eq!(names, [("Speed", 3), ("Count", 6), ("Flow", 7)]);
    assert_eq!(formula.horizon().as_nanos(), 1_500_000_000);
    assert_eq!(formula.text(), text);
}
