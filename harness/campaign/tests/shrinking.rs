//! What shrinking leaves of a fault that has to be there at a certain time.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use campaign::{Case, CaseResult, Executor, Violated, shrink};
use plan::Name;
use plan::faults::{Fault, FaultKind, Schedule, Target, When};
use proptest::prelude::*;
use wire::time::Span;

/// The property that breaks.
const HELD: &str = "held";
/// Begin of the only phase, s.
const PHASE_S: f64 = 5.0;
/// The most runs of shrinking.
const RUNS_MAX: u64 = 500;

/// Breaks if one fault of `kind` is there from `from_s` to `to_s`, `deadline_s` later.
#[derive(Debug, Clone, Copy)]
struct Needs {
    kind: &'static str,
    from_s: f64,
    to_s: f64,
    deadline_s: f64,
}

fn lasting_s(fault: &Fault) -> f64 {
    fault.lasting().map_or(f64::INFINITY, Span::as_secs_f64)
}

fn begin(fault: &Fault) -> Span {
    let phase = Span::from_secs_f64(PHASE_S);
    match &fault.when {
        When::Always => Span::ZERO,
        When::At(at) => *at,
        When::Step { after, .. } => phase + *after,
        When::During { .. } => phase,
    }
}

impl Executor for Needs {
    fn execute(&self, case: &Case) -> CaseResult {
        let is_enough = |fault: &Fault| {
            let end = begin(fault) + fault.lasting().unwrap_or(Span::MAX);
            let [from, to] = [self.from_s, self.to_s].map(Span::from_secs_f64);
            fault.what.name() == self.kind && begin(fault) <= from && to <= end
        };
        let mut result = CaseResult::ended("passed");
        if case.schedule.faults.iter().any(is_enough) {
            let (property, at_s) = (HELD.to_owned(), self.to_s + self.deadline_s);
            result.violated.push(Violated { property, at_s, what: String::new() });
        }
        result
    }
}

fn case(fault: Fault) -> Case {
    Case { seed: 1, schedule: Schedule { faults: vec![fault] } }
}

fn fault(kind: &str, when: When, lasting_s: f64) -> Fault {
    let what = FaultKind::typical(kind).unwrap();
    let fault = Fault { when, ..Fault::new(Target::Base, what) };
    match kind {
        "drop" => Fault { duration: Some(Span::from_secs_f64(lasting_s)), ..fault },
        _ => Fault { what: what.with_severity(lasting_s), ..fault },
    }
}

/// Found by a user: a plug that was out for 7 s from 1.07 s on, of which the last 0.4 s matter.
#[test]
fn a_fault_that_matters_at_its_end_begins_as_late_as_it_can() {
    let phase = || Name::new("idle").unwrap();
    let starts = [
        When::At(Span::from_millis(1_070)),
        When::Step { phase: phase(), number: 1, after: Span::ZERO },
        When::During { phase: phase(), number: 1 },
        When::Always,
    ];
    for when in starts {
        for kind in ["disconnect", "drop"] {
            let needs = Needs { kind, from_s: 7.3, to_s: 7.65, deadline_s: 0.2 };
            let case = case(fault(kind, when.clone(), 9.0));
            let result = needs.execute(&case);
            let shrunk = shrink(&needs, &case, &result, HELD, RUNS_MAX);
            let [left] = shrunk.case.schedule.faults.as_slice() else { panic!("{shrunk:?}") };
            assert!(shrunk.executions <= 60, "{} runs: {left:?}", shrunk.executions);
            assert!(lasting_s(left) <= 0.5, "{left:?}");
            assert!(needs.execute(&shrunk.case).breaks(HELD), "{left:?}");
        }
    }
}

/// Found by the property below: its end fell on the instant that matters, and no later begin was enough by a rounding error.
#[test]
fn a_fault_that_ends_at_the_instant_that_matters_begins_later() {
    let needs = Needs { kind: "refuse_commands", from_s: 18.483, to_s: 18.504, deadline_s: 0.0 };
    let when = When::Step { phase: Name::new("idle").unwrap(), number: 1, after: Span::ZERO };
    let case = case(fault(needs.kind, when, 15.489));
    let result = needs.execute(&case);
    let shrunk = shrink(&needs, &case, &result, HELD, RUNS_MAX);
    let [left] = shrunk.case.schedule.faults.as_slice() else { panic!("{shrunk:?}") };
    assert!(lasting_s(left) <= 2.5 * 0.021, "{left:?}");
}

/// Found by the property below: of four decades and more, six bisections left a fifth too much, and 8 s became 20 s.
#[test]
fn a_length_of_many_decades_is_found_to_a_tenth() {
    let needs = Needs { kind: "refuse_commands", from_s: 40.676, to_s: 48.666, deadline_s: 0.0 };
    let after = Span::from_millis(144);
    let when = When::Step { phase: Name::new("idle").unwrap(), number: 1, after };
    let case = case(fault(needs.kind, when, 57.339));
    let result = needs.execute(&case);
    let shrunk = shrink(&needs, &case, &result, HELD, RUNS_MAX);
    let [left] = shrunk.case.schedule.faults.as_slice() else { panic!("{shrunk:?}") };
    assert!(lasting_s(left) <= 10.0, "{left:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// What is left breaks the property, and lasts about as long as it has to.
    #[test]
    fn the_shortest_fault_that_breaks_is_left(
        (from_ms, needs_ms) in (5_000_i64..60_000, 1_i64..8_000),
        (before_ms, behind_ms, deadline_ms) in (0_i64..60_000, 0_i64..20_000, 0_i64..2_000),
        kind in prop_oneof![Just("disconnect"), Just("drop"), Just("refuse_commands")],
        of_phase in any::<bool>(),
    ) {
        let seconds = |ms: i64| ms as f64 * 1e-3;
        let needs = Needs {
            kind,
            from_s: seconds(from_ms),
            to_s: seconds(from_ms + needs_ms),
            deadline_s: seconds(deadline_ms),
        };
        let begin_ms = from_ms - before_ms.min(from_ms - 5_000);
        let when = match of_phase {
            true => When::Step {
                phase: Name::new("idle").unwrap(),
                number: 1,
                after: Span::from_millis(begin_ms) - Span::from_secs_f64(PHASE_S),
            },
            false => When::At(Span::from_millis(begin_ms)),
        };
        let lasting_s = seconds(from_ms - begin_ms + needs_ms + behind_ms);
        let case = case(fault(kind, when, lasting_s));
        let result = needs.execute(&case);
        prop_assert!(result.breaks(HELD));
        let shrunk = shrink(&needs, &case, &result, HELD, RUNS_MAX);
        let [left] = shrunk.case.schedule.faults.as_slice() else { panic!("{shrunk:?}") };
        prop_assert!(shrunk.result.breaks(HELD) && needs.execute(&shrunk.case).breaks(HELD));
        // Two bisections to a tenth, and rounded up to one digit: 1.1 s becomes 2 s.
        let least_s = seconds(needs_ms).max(0.01);
        prop_assert!(self::lasting_s(left) <= 2.5 * least_s, "{left:?}");
        prop_assert!(shrunk.executions <= 90, "{}", shrunk.executions);
    }
}
