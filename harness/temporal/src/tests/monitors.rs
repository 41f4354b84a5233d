//! Verdicts over a run.

use super::{at, formula};
use crate::{Monitor, Truth, Verdict};
use wire::time::{Span, Timestamp};

const SPEED: usize = 3;
const COUNT: usize = 6;

/// The verdict on a run with these updates that ends at `end`.
fn verdict(text: &str, updates: &[(i64, usize, f64)], end: i64) -> Verdict {
    let mut monitor = Monitor::new(formula(text));
    for (time, signal, value) in updates {
        monitor.update(at(*time), &[(*signal, *value)]);
    }
    monitor.finish(at(end))
}

#[test]
fn a_formula_that_holds_tells_its_worst_moment() {
    let verdict = verdict("Count < 10", &[(0, COUNT, 1.0), (5, COUNT, 8.0), (9, COUNT, 2.0)], 20);
    assert!(verdict.holds);
    assert_eq!((verdict.robustness, verdict.worst), (2.0, Some(at(5))));
    // Both ends belong to the run.
    assert_eq!((verdict.judged, verdict.unknown), (Span::from_nanos(21), Span::ZERO));
    assert_eq!((verdict.violations, verdict.open), (0, 0));
}

#[test]
fn a_violation_is_told_with_its_moment_and_its_values() {
    let text = "rises(Speed > 3) -> within 10 ns: Count == 1";
    let updates = [
        (0, SPEED, 0.0),
        (0, COUNT, 0.0),
        (20, SPEED, 5.0),
        (25, COUNT, 1.0),
        (40, COUNT, 0.0),
        (50, SPEED, 2.0),
        (60, SPEED, 7.0),
        (71, COUNT, 1.0),
    ];
    let verdict = verdict(text, &updates, 200);
    assert!(!verdict.holds);
    assert_eq!((verdict.violations, verdict.violated), (1, Span::from_nanos(1)));
    let violation = verdict.first_violation.expect("the second answer is late");
    assert_eq!((violation.at, violation.known), (at(60), at(70)));
    // It was 1 before it rose; the minimum of the three margins.
    assert_eq!((violation.distance, verdict.robustness), (-1.0, -1.0));
    assert_eq!(violation.values, [("Speed".to_owned(), 7.0), ("Count".to_owned(), 0.0)]);
}

#[test]
fn the_distance_of_a_violation_has_the_unit_of_the_comparison_that_decides() {
    let unit = |text: &str| {
        let verdict = verdict(text, &[(0, COUNT, 2.0), (0, SPEED, 50.0)], 10);
        verdict.first_violation.unwrap().unit
    };
    assert_eq!(unit("Speed < 3 m/s"), "km/h");
    assert_eq!(unit("Count < 1"), "");
    assert_eq!(unit("Count < 3 and 2 * Speed < 30"), "km/h");
}

#[test]
fn an_answer_at_the_very_end_of_the_window_is_in_time() {
    let text = "rises(Speed > 3) -> within 10 ns: Count == 1";
    let run = |answer| {
        let updates = [(0, SPEED, 0.0), (0, COUNT, 0.0), (20, SPEED, 5.0), (answer, COUNT, 1.0)];
        verdict(text, &updates, 100).holds
    };
    assert!(run(30));
    assert!(!run(31));
}

#[test]
fn what_the_end_leaves_open_is_no_violation() {
    let text = "rises(Speed > 3) -> within 10 ns: Count == 1";
    let updates = [(0, SPEED, 0.0), (0, COUNT, 0.0), (20, SPEED, 5.0)];
    for (end, violations, open) in [(29, 0, 1), (30, 1, 0)] {
        let verdict = verdict(text, &updates, end);
        assert_eq!((verdict.violations, verdict.open), (violations, open), "end at {end}");
        assert_eq!(verdict.unknown, Span::ZERO);
    }
    // Already decided: later values cannot change it.
    let decided = verdict("for 10 ns: Count == 1", &[(0, COUNT, 1.0), (5, COUNT, 0.0)], 6);
    assert_eq!(decided.first_violation.map(|violation| violation.known), Some(at(6)));
    let open = verdict("for 10 ns: Count == 1", &[(0, COUNT, 1.0)], 6);
    assert_eq!((open.holds, open.open, open.judged), (true, 1, Span::ZERO));
    // Unknown because of the signal, not the end: the whole horizon is within the run.
    let silent = verdict("within 10 ns: Speed + Count > 0", &[(0, COUNT, 1.0)], 30);
    assert_eq!((silent.unknown, silent.open), (Span::from_nanos(21), 1));
}

#[test]
fn a_violation_that_nothing_can_avert_is_known_at_the_end_before_the_horizon_is_over() {
    let mut monitor = Monitor::new(formula("for 1 s: Count == 1"));
    monitor.update(at(0), &[(COUNT, 1.0)]);
    monitor.update(at(50), &[(COUNT, 0.0)]);
    assert!(monitor.verdict().holds);
    assert_eq!(monitor.finish(at(50)).first_violation.map(|violation| violation.at), Some(at(0)));
}

#[test]
fn a_signal_without_a_value_is_not_judged() {
    let text = "Speed > 3 or Count == 1";
    let late = verdict(text, &[(0, COUNT, 0.0), (10, SPEED, 5.0)], 19);
    assert_eq!(
        (late.holds, late.unknown, late.judged),
        (true, Span::from_nanos(10), Span::from_nanos(10))
    );
    // The other operand decides alone.
    let decided = verdict(text, &[(0, COUNT, 1.0), (10, SPEED, 5.0)], 19);
    assert_eq!(decided.unknown, Span::ZERO);
    let never = verdict(text, &[], 19);
    assert_eq!((never.judged, never.worst, never.robustness), (Span::ZERO, None, f64::INFINITY));
    let lost =
        verdict("Count == 1", &[(0, COUNT, 1.0), (10, COUNT, f64::NAN), (15, COUNT, 1.0)], 19);
    assert_eq!((lost.unknown, lost.judged), (Span::from_nanos(5), Span::from_nanos(15)));
    assert_eq!(lost.open, 0);
}

#[test]
fn a_first_value_is_a_change() {
    let updates = [(0, SPEED, 0.0), (5, COUNT, 1.0), (9, COUNT, f64::NAN), (12, COUNT, 1.0)];
    for change in ["rises(Count > 0)", "falls(Count < 0)", "changes(Count)"] {
        let verdict = verdict(&format!("{change} -> Speed > 100"), &updates, 20);
        // Once: between two equal values one is missing.
        assert_eq!((verdict.violations, verdict.violated), (1, Span::from_nanos(1)), "{change}");
        assert_eq!(verdict.first_violation.unwrap().at, at(5));
    }
}

/// What may still come after the end is open: also an edge of what is true at the end, which could fall and rise again.
#[test]
fn an_edge_may_come_after_the_end() {
    let updates = [(0, COUNT, 0.0), (10, COUNT, 3.0), (40, COUNT, 0.0), (80, COUNT, 3.0)];
    for formula in [
        "Count == 3 -> within 50 ns: falls(Count == 3)",
        "Count == 3 -> within 50 ns: falls(Count == 1)",
        "Count == 3 -> within 50 ns: rises(Count == 3)",
        "Count == 3 -> within 50 ns: rises(within 20 ns: Count == 3)",
        "Count == 3 -> within 50 ns: changes(Count)",
    ] {
        // At 10 everything is certain at 60, and at 80 nothing is.
        let early = verdict(formula, &updates[2..], 100);
        assert!(early.holds && early.open > 0, "{formula}: {early:?}");
    }
    // The same without an end in sight.
    let late = verdict("Count == 3 -> within 50 ns: falls(Count == 1)", &updates[2..], 140);
    assert_eq!(late.first_violation.map(|violation| violation.at), Some(at(80)));
}

#[test]
fn what_is_asked_before_a_first_value_is_unanswered() {
    let mut monitor = Monitor::new(formula("Speed > 3 -> within 10 ns: Count == 1"));
    monitor.update(at(0), &[(SPEED, 0.0)]);
    monitor.update(at(20), &[(SPEED, 5.0)]);
    monitor.update(at(25), &[(SPEED, 0.0)]);
    monitor.advance(at(28));
    assert_eq!(monitor.unanswered(), None);
    monitor.update(at(50), &[(COUNT, 0.0)]);
    let stretch = monitor.unanswered().unwrap();
    assert_eq!((stretch.from, stretch.to, monitor.limit()), (at(20), at(25), Span::from_nanos(10)));
    assert_eq!(monitor.unanswered(), None);
    monitor.all_seen();
    let verdict = monitor.finish(at(100));
    assert!(verdict.holds);
    assert_eq!(verdict.never_asked.as_deref(), Some("Speed > 3"));
}

#[test]
fn a_frame_is_one_moment() {
    let text = "Speed == Count";
    let mut monitor = Monitor::new(formula(text));
    monitor.update(at(0), &[(SPEED, 1.0), (COUNT, 1.0)]);
    monitor.update(at(10), &[(SPEED, 2.0), (COUNT, 2.0)]);
    // The same holds for frames at one moment: the last values count.
    monitor.update(at(20), &[(SPEED, 3.0)]);
    monitor.update(at(20), &[(COUNT, 9.0)]);
    monitor.update(at(20), &[(COUNT, 3.0)]);
    assert!(monitor.finish(at(30)).holds);
}

#[test]
fn times_that_go_back_count_as_now() {
    let mut monitor = Monitor::new(formula("Count < 5"));
    monitor.update(at(100), &[(COUNT, 1.0)]);
    monitor.update(at(50), &[(COUNT, 7.0)]);
    monitor.advance(at(20));
    let verdict = monitor.finish(at(10));
    assert_eq!(verdict.first_violation.map(|violation| violation.at), Some(at(100)));
    assert_eq!(verdict.judged, Span::from_nanos(1));
}

#[test]
fn the_ends_of_time_and_of_numbers_do_no_harm() {
    for text in [
        "Count < 5",
        "once [1 s, 1 h]: Count < 5",
        "historically: within 1 h: Count < 5",
        "Count < 5 until [1 ns, 1 h] Speed > 3",
        "Count < 5 since [1 ns, 1 h] Speed > 3",
        "rises(Count < 5) or changes(Speed)",
    ] {
        let mut monitor = Monitor::new(formula(text));
        for time in [i64::MIN, -1, 0, 1, 1 << 40, i64::MAX - 1, i64::MAX] {
            for value in
                [f64::MAX, f64::MIN, f64::INFINITY, f64::NEG_INFINITY, f64::MIN_POSITIVE, -0.0]
            {
                monitor.update(at(time), &[(COUNT, value), (SPEED, -value)]);
            }
            monitor.advance(at(time));
        }
        let _ = monitor.finish(Timestamp::MAX);
    }
    let far = verdict("Count > Speed", &[(0, SPEED, -1e308), (0, COUNT, f64::MAX)], 9);
    assert_eq!((far.holds, far.robustness), (true, f64::INFINITY));
    let equal = [(0, SPEED, f64::INFINITY), (0, COUNT, f64::INFINITY)];
    assert_eq!(verdict("Count == Speed", &equal, 9).robustness, 0.0);
}

#[test]
fn a_window_may_be_a_moment_now_or_later() {
    let updates = [(0, COUNT, 0.0), (10, COUNT, 1.0), (20, COUNT, 0.0)];
    for (text, violated) in [
        ("always [0, 0]: Count == 0", 10),
        ("eventually [0, 0]: Count == 0", 10),
        ("once [0, 0]: Count == 0", 10),
        ("eventually [5 ns, 5 ns]: Count == 0", 10),
        ("historically [5 ns, 5 ns]: Count == 0", 10),
        ("for 1 ns: Count == 0", 11),
        ("within 1 ns: Count == 0", 9),
    ] {
        assert_eq!(verdict(text, &updates, 100).violated, Span::from_nanos(violated), "{text}");
    }
}

#[test]
fn the_past_begins_with_the_run() {
    let updates = [(5, COUNT, 0.0), (20, COUNT, 1.0)];
    // Every moment of an empty set, some moment of an empty set.
    assert!(verdict("historically [50 ns, 60 ns]: Count == 7", &updates, 30).holds);
    let none = verdict("once [50 ns, 60 ns]: Count == 0", &updates, 30);
    assert_eq!(
        (none.first_violation.map(|it| it.at), none.robustness),
        (Some(at(5)), f64::NEG_INFINITY)
    );
    let since = verdict("Count == 1 since Count == 0", &updates, 30);
    assert!(since.holds);
    assert_eq!(since.judged, Span::from_nanos(26));
}

#[test]
fn a_gap_of_an_hour_costs_nothing() {
    let mut monitor = Monitor::new(formula("Speed > 3 -> within 1 h: Count == 1"));
    let hour = Span::from_secs(3_600);
    monitor.update(at(0), &[(SPEED, 5.0), (COUNT, 0.0)]);
    monitor.update(at(0) + hour, &[(COUNT, 1.0)]);
    monitor.advance(at(0) + hour * 1_000);
    let verdict = monitor.verdict();
    assert!(verdict.holds);
    assert_eq!(verdict.judged, hour * 999);
}

#[test]
fn memory_is_what_changed_within_the_horizon() {
    let mut monitor = Monitor::new(formula(
        "(Speed > 3 until [10 ns, 1 us] Count > 5) or historically: once [0, 1 us]: Count > Speed",
    ));
    let run = |monitor: &mut Monitor, from: i64| {
        for time in from..from + 20_000 {
            let value = (time * 7919 % 11) as f64;
            monitor.update(at(time), &[(SPEED, value), (COUNT, 10.0 - value)]);
        }
        format!("{monitor:?}").len()
    };
    let first = run(&mut monitor, 0);
    let later = run(&mut monitor, 20_000);
    assert!(later < first + first / 10, "{first} bytes, then {later}");
}

#[test]
fn truth_can_be_printed() {
    assert_eq!(format!("{:?} {:?}", Truth::new(false, 2.5), Truth::UNKNOWN), "false(-2.5) unknown");
}

#[test]
fn an_implication_whose_left_side_was_never_true_asked_for_nothing() {
    let text = "rises(Speed > 3) -> within 10 ns: Count == 1";
    let start = [(0, SPEED, 0.0), (0, COUNT, 1.0)];
    let asked = |updates: &[(i64, usize, f64)], end| {
        let verdict = verdict(text, &[&start[..], updates].concat(), end);
        assert!(verdict.holds);
        verdict.never_asked
    };
    assert_eq!(asked(&[(20, SPEED, 2.0)], 100).as_deref(), Some("rises(Speed > 3)"));
    assert_eq!(asked(&[(20, SPEED, 5.0)], 100), None);
    // The only answer might still have come.
    let open = [(10, COUNT, 0.0), (20, SPEED, 5.0)];
    assert_eq!(asked(&open, 25).as_deref(), Some("rises(Speed > 3)"));
    // A violation was asked for, and a formula without `->` always is.
    for text in [text, "Count == 1"] {
        assert_eq!(verdict(text, &[&start[..], &open[..]].concat(), 100).never_asked, None);
    }
}

const REQUEST: usize = 8;
const ANSWER: usize = 9;

/// Found by a user: of a message that was never sent, nothing could be said.
#[test]
fn what_must_never_be_sent_is_judged_without_it() {
    let never = verdict("not sent(cells.Answer)", &[], 20);
    assert!(never.holds && never.worst.is_some(), "{never:?}");
    let once = verdict("not sent(cells.Answer)", &[(7, ANSWER, 1.0)], 20);
    let violation = once.first_violation.expect("it was sent");
    assert_eq!((violation.at, once.violated), (at(7), Span::from_nanos(1)));
    assert_eq!(violation.values, [("number of cells.Answer sent".to_owned(), 1.0)]);
}

/// Found by a user: a node that started too late owed nothing before its first message.
#[test]
fn an_answer_is_due_before_anything_was_heard_of_it() {
    let text = "sent(Request) -> within 10 ns: sent(cells.Answer)";
    let late = verdict(text, &[(3, REQUEST, 1.0), (40, REQUEST, 2.0), (45, ANSWER, 1.0)], 90);
    assert_eq!(late.first_violation.map(|one| one.at), Some(at(3)));
    let in_time = verdict(text, &[(3, REQUEST, 1.0), (13, ANSWER, 1.0), (85, REQUEST, 2.0)], 90);
    assert!(in_time.holds && in_time.never_asked.is_none(), "{in_time:?}");
    assert!(verdict(text, &[], 90).never_asked.is_some());
    let twice = verdict(
        "sent(Request) -> not once [1 ns, 10 ns]: sent(Request)",
        &[(3, REQUEST, 1.0), (9, REQUEST, 2.0)],
        90,
    );
    assert_eq!(twice.first_violation.map(|one| one.at), Some(at(9)));
}

#[test]
fn a_message_that_nobody_sends_is_refused() {
    let wrong = |text: &str| super::read(text).unwrap_err().to_string();
    assert_eq!(wrong("sent(Reqest)"), "no signal `Reqest`");
    assert_eq!(wrong("sent(3)"), "expected a message, found `3`");
    assert_eq!(wrong("sent(Request) > 1"), "`>` compares numbers, not conditions");
}
