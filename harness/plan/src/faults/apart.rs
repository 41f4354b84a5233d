//! Whether two faults can be active at the same time. Decided before the run from the order of the plan's phases and
//! the bounds of their times.

use super::{Fault, When};
use crate::Plan;
use crate::timeline::{Stretch, nests, stretches};
use wire::time::Span;

/// What is known about two faults before the run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Meeting {
    /// They are never active at the same time.
    Never,
    /// They are active at the same time.
    Sure,
    /// It depends on the course of the run.
    Possible,
}

/// The longest interval in which a fault can be active.
#[derive(Debug, Clone, Copy)]
struct Extent {
    earliest: Span,
    latest_end: Span,
}

pub(super) fn meeting(plan: &Plan, one: &Fault, other: &Fault) -> Meeting {
    if let (Some(a), Some(b)) = (fixed(one), fixed(other)) {
        return if apart(a, b) { Meeting::Never } else { Meeting::Sure };
    }
    if one.when == other.when {
        return Meeting::Sure;
    }
    let phases = [one, other].map(|fault| fault.when.phase());
    let wanted: Vec<(&str, u32)> =
        phases.iter().flatten().map(|(name, number)| (name.as_str(), *number)).collect();
    let mut found = stretches(plan, &wanted).into_iter();
    let [a, b] = phases.map(|phase| phase.and_then(|_| found.next().flatten()));
    let follow = match (&one.when, &other.when) {
        (When::During { phase: p, .. }, When::During { phase: q, .. }) => {
            p == q && !nests(plan, p.as_str())
        }
        _ => false,
    };
    let never = follow
        || apart(extent(one, a), extent(other, b))
        || a.zip(b).is_some_and(|(a, b)| {
            is_over_before(one, &a, other, &b) || is_over_before(other, &b, one, &a)
        });
    if never { Meeting::Never } else { Meeting::Possible }
}

/// The interval of a fault that is not tied to a phase.
fn fixed(fault: &Fault) -> Option<Extent> {
    fault.when.phase().is_none().then(|| extent(fault, None))
}

const fn apart(a: Extent, b: Extent) -> bool {
    a.latest_end.as_nanos() <= b.earliest.as_nanos()
        || b.latest_end.as_nanos() <= a.earliest.as_nanos()
}

/// The longest interval; `phase` is the phase that the fault waits for, if known.
fn extent(fault: &Fault, phase: Option<Stretch>) -> Extent {
    let lasting = fault.lasting().unwrap_or(Span::MAX);
    match (&fault.when, phase) {
        (When::Always, _) => Extent { earliest: Span::ZERO, latest_end: lasting },
        (When::At(at), _) => Extent { earliest: *at, latest_end: *at + lasting },
        (_, None) => Extent { earliest: Span::ZERO, latest_end: Span::MAX },
        (When::Step { after, .. }, Some(phase)) => Extent {
            earliest: phase.begins.earliest + *after,
            latest_end: phase.begins.latest + *after + lasting,
        },
        (When::During { .. }, Some(phase)) => Extent {
            earliest: phase.begins.earliest,
            latest_end: phase.ends.latest.min(phase.begins.latest + lasting),
        },
    }
}

/// Whether the order of their phases ensures that `first` is over before `then` begins.
fn is_over_before(first: &Fault, a: &Stretch, then: &Fault, b: &Stretch) -> bool {
    let ends_with_phase = matches!(first.when, When::During { .. });
    if ends_with_phase && a.order.1 <= b.order.0 {
        return true;
    }
    if a.order.0 > b.order.0 {
        return false;
    }
    // The steps between the two phases take at least this time.
    let between = b.begins.earliest - a.begins.earliest;
    let after = |fault: &Fault| match fault.when {
        When::Step { after, .. } => after,
        _ => Span::ZERO,
    };
    let over = first.lasting().map_or(Span::MAX, |lasting| after(first) + lasting);
    over <= between + after(then)
}

#[cfg(test)]
mod tests {
    use super::{Meeting, meeting};
    use crate::faults::{Fault, FaultKind, Target, When};
    use crate::{Name, Plan};
    use wire::time::Span;

    /// Bias tests of 20 s and turns of at least 2.5 s; rounds begin every 30 s.
    const PLAN: &str = r#"
name = "p"
title = ""
devices = "paper"
steps = [
    { wait = { duration_s = 10 } },
    { repeat = { times = 3, period_s = 30, steps = [
        { bias_test = { duration_s = 20 } },
        { turn = { angle_deg = 90 } },
    ] }, label = "round" },
]
[[measurement]]
name = "m"
doc = "d"
quantity = "lap.gyro_error"
unit = "deg"
check = { all_within = [-1, 1] }
"#;

    fn name(text: &str) -> Name {
        Name::new(text).unwrap()
    }

    fn step(phase: &str, number: u32, after_s: i64) -> When {
        When::Step { phase: name(phase), number, after: Span::from_secs(after_s) }
    }

    fn during(phase: &str, number: u32) -> When {
        When::During { phase: name(phase), number }
    }

    /// Stuck for `one_s`, and stuck for `other_s`.
    fn met(one: (When, f64), other: (When, f64)) -> Meeting {
        let plan = Plan::parse("p.toml", PLAN).unwrap();
        let fault =
            |(when, for_s)| Fault { when, ..Fault::new(Target::Gyro, FaultKind::Stuck { for_s }) };
        let (one, other) = (fault(one), fault(other));
        let there = meeting(&plan, &one, &other);
        assert_eq!(there, meeting(&plan, &other, &one), "the order of the two is nothing");
        there
    }

    #[test]
    fn known_times_decide() {
        let at = |seconds| When::At(Span::from_secs(seconds));
        assert_eq!(met((at(10), 5.0), (at(15), 5.0)), Meeting::Never);
        assert_eq!(met((at(10), 5.0), (at(14), 5.0)), Meeting::Sure);
        assert_eq!(met((When::Always, 5.0), (at(4), 1.0)), Meeting::Sure);
    }

    #[test]
    fn phases_that_follow_one_another_are_apart_as_long_as_a_fault_ends_with_its_own() {
        assert_eq!(met((during("turn", 1), 60.0), (during("turn", 2), 60.0)), Meeting::Never);
        assert_eq!(met((during("bias_test", 1), 60.0), (during("turn", 1), 60.0)), Meeting::Never);
        assert_eq!(met((during("bias_test", 1), 60.0), (step("turn", 1, 0), 60.0)), Meeting::Never);
        assert_eq!(
            met((step("bias_test", 1, 0), 60.0), (during("turn", 1), 60.0)),
            Meeting::Possible
        );
        // One lies within the other.
        assert_eq!(met((during("round", 1), 60.0), (during("turn", 1), 60.0)), Meeting::Possible);
        assert_eq!(met((during("round", 1), 60.0), (during("turn", 2), 60.0)), Meeting::Never);
    }

    #[test]
    fn what_lies_between_two_phases_takes_its_time() {
        assert_eq!(met((step("bias_test", 1, 0), 20.0), (step("turn", 1, 0), 1.0)), Meeting::Never);
        assert_eq!(
            met((step("bias_test", 1, 0), 20.1), (step("turn", 1, 0), 1.0)),
            Meeting::Possible
        );
        assert_eq!(met((step("bias_test", 1, 5), 20.0), (step("turn", 1, 5), 1.0)), Meeting::Never);
        // Rounds begin at least 30 s apart.
        assert_eq!(met((step("round", 1, 0), 30.0), (step("round", 2, 0), 30.0)), Meeting::Never);
        assert_eq!(
            met((step("round", 1, 0), 31.0), (step("round", 2, 0), 30.0)),
            Meeting::Possible
        );
        assert_eq!(met((during("turn", 1), 1.0), (during("turn", 1), 2.0)), Meeting::Sure);
    }

    #[test]
    fn a_time_is_held_against_the_bounds_of_a_phase() {
        let at = |seconds| When::At(Span::from_secs(seconds));
        // The first bias test begins between 10 s and 20 s.
        assert_eq!(met((at(1), 9.0), (step("bias_test", 1, 0), 1.0)), Meeting::Never);
        assert_eq!(met((at(1), 9.5), (step("bias_test", 1, 0), 1.0)), Meeting::Possible);
        assert_eq!(met((at(21), 9.5), (step("bias_test", 1, 0), 1.0)), Meeting::Never);
        assert_eq!(met((at(20), 9.5), (step("bias_test", 1, 0), 1.0)), Meeting::Possible);
    }
}
