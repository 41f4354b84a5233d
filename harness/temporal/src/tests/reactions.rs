//! Response times.

use super::{at, formula};
use crate::Reaction;
use proptest::prelude::*;

const SPEED: usize = 3;
const COUNT: usize = 6;

/// Triggers and their response times, in nanoseconds.
fn answers(reaction: &mut Reaction) -> Vec<(i64, i64)> {
    std::iter::from_fn(|| reaction.take())
        .map(|answer| (answer.asked.as_nanos(), answer.after.as_nanos()))
        .collect()
}

#[test]
fn each_question_gets_the_next_answer() {
    let mut reaction = Reaction::new(&formula("Speed > 3"), &formula("Count == 1"), 10);
    reaction.update(at(0), &[(SPEED, 0.0), (COUNT, 0.0)]);
    reaction.update(at(10), &[(SPEED, 5.0)]);
    reaction.update(at(12), &[(SPEED, 0.0)]);
    reaction.update(at(15), &[(SPEED, 5.0)]);
    assert_eq!(reaction.waiting().count(), 1);
    reaction.update(at(40), &[(COUNT, 1.0)]);
    reaction.update(at(50), &[(SPEED, 0.0)]);
    // Already true.
    reaction.update(at(60), &[(SPEED, 9.0)]);
    reaction.update(at(70), &[(COUNT, 0.0), (SPEED, 0.0)]);
    reaction.update(at(80), &[(SPEED, 9.0)]);
    reaction.finish(at(100));
    assert_eq!(answers(&mut reaction), [(10, 30), (15, 25), (60, 0)]);
    assert_eq!((reaction.waiting().count(), reaction.dropped()), (1, 0));
}

#[test]
fn what_begins_true_asks() {
    let mut reaction = Reaction::new(&formula("Speed > 3"), &formula("Count == 1"), 10);
    reaction.update(at(0), &[(SPEED, 5.0)]);
    reaction.update(at(10), &[(COUNT, 1.0)]);
    reaction.finish(at(100));
    assert_eq!((answers(&mut reaction), reaction.waiting().count()), (vec![(0, 10)], 0));
}

#[test]
fn formulas_that_look_ahead_are_measured_when_they_are_known() {
    // It counts once it has settled.
    let settled = formula("for 20 ns: Count == 1");
    let mut reaction = Reaction::new(&formula("Speed > 3"), &settled, 10);
    reaction.update(at(0), &[(SPEED, 0.0), (COUNT, 0.0)]);
    reaction.update(at(10), &[(SPEED, 5.0)]);
    reaction.update(at(15), &[(COUNT, 1.0)]);
    reaction.update(at(20), &[(COUNT, 0.0)]);
    reaction.update(at(30), &[(COUNT, 1.0)]);
    reaction.advance(at(50));
    assert_eq!(answers(&mut reaction), []);
    reaction.advance(at(51));
    assert_eq!(answers(&mut reaction), [(10, 20)]);
}

#[test]
fn an_answer_is_foreseen_where_no_value_comes_any_more() {
    let due = |to: &str, since: i64, until: i64| {
        let mut reaction = Reaction::new(&formula("Speed > 3"), &formula(to), 10);
        reaction.update(at(0), &[(SPEED, 0.0), (COUNT, 0.0)]);
        reaction.update(at(10), &[(SPEED, 5.0)]);
        reaction.update(at(15), &[(COUNT, 1.0)]);
        let due = reaction.due(at(since), at(until))?;
        reaction.advance(due);
        assert_eq!(answers(&mut reaction).len(), 1, "{to}");
        Some(due.as_nanos())
    };
    assert_eq!(due("Count == 1", 0, 100), Some(16));
    assert_eq!(due("for 20 ns: Count == 1", 0, 100), Some(36));
    assert_eq!(due("historically [0 s, 30 ns]: Count == 1", 0, 100), Some(46));
    assert_eq!(due("for 20 ns: Count == 1", 0, 36), Some(36));
    assert_eq!(due("for 20 ns: Count == 1", 0, 35), None);
    assert_eq!(due("Count == 1", 11, 100), None, "asked before");
    assert_eq!(due("Count == 2", 0, 100), None);
}

#[test]
fn what_has_no_place_is_counted() {
    let mut reaction = Reaction::new(&formula("Speed > 3"), &formula("Count == 1"), 2);
    reaction.update(at(0), &[(SPEED, 0.0), (COUNT, 0.0)]);
    for question in 1..=5 {
        reaction.update(at(question * 10), &[(SPEED, 5.0)]);
        reaction.update(at(question * 10 + 5), &[(SPEED, 0.0)]);
    }
    reaction.update(at(100), &[(COUNT, 1.0)]);
    reaction.update(at(110), &[(SPEED, 5.0)]);
    reaction.finish(at(200));
    assert_eq!(answers(&mut reaction), [(10, 90), (20, 80)]);
    assert_eq!((reaction.waiting().count(), reaction.dropped()), (0, 4));
}

proptest! {
    #[test]
    fn answers_are_those_that_a_loop_finds(rows in prop::collection::vec((0..3i32, 0..3i32), 1..60)) {
        let mut reaction = Reaction::new(&formula("Speed > 1"), &formula("Count > 1"), 100);
        let mut expected = Vec::new();
        let mut waiting: Vec<i64> = Vec::new();
        let mut was_asked = false;
        for (time, (speed, count)) in (0..).zip(&rows) {
            let values = [(SPEED, f64::from(*speed)), (COUNT, f64::from(*count))];
            reaction.update(at(time), &values);
            let is_asked = *speed > 1;
            if is_asked && !was_asked {
                waiting.push(time);
            }
            was_asked = is_asked;
            if *count > 1 {
                expected.extend(waiting.drain(..).map(|asked| (asked, time - asked)));
            }
        }
        reaction.finish(at(rows.len() as i64 - 1));
        prop_assert_eq!(answers(&mut reaction), expected);
        prop_assert_eq!(reaction.waiting().count(), waiting.len());
    }
}
