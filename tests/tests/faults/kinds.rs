//! Every kind of fault, on every bench that it can strike.

use super::{FaultEvent, prepared, run, told};
use plan::faults::{Fault, FaultKind, Lasts, Lines, Schedule, Target, When};
use record::outcome::Outcome;
use std::sync::Arc;
use wire::time::Span;

/// Returns the fault with a severity that acts within a few seconds.
fn acting(kind: FaultKind) -> FaultKind {
    let first = &kind.info().parameters[0];
    if first.unit == "%" && kind.severity() < 20.0 { kind.with_severity(20.0) } else { kind }
}

/// A fault of this kind in the straight line, or in the table's turn.
fn schedule(target: Target, kind: FaultKind) -> Schedule {
    let mut fault = Fault::new(target, acting(kind));
    if target != Target::Operator {
        fault.when = When::At(Span::from_millis(3_000));
    }
    if kind.info().lasts == Lasts::Scheduled && target != Target::Operator {
        fault.duration = Some(Span::from_secs(5));
    }
    Schedule { faults: vec![fault] }
}

#[test]
fn each_begins_acts_and_ends_wherever_it_can() {
    let benches = [
        ("paper", Lines::CAN_BASE),
        ("paper-serial", Lines::SERIAL_BASE),
        ("paper-table", Lines::TABLE),
    ];
    let mut tried = 0;
    for info in FaultKind::all() {
        for (target, (devices, lines)) in info
            .reach
            .targets()
            .iter()
            .flat_map(|target| benches.clone().map(|bench| (*target, bench)))
        {
            let schedule = schedule(target, info.typical);
            if schedule.check_bench(&lines).is_err()
                || (target == Target::Operator && lines == Lines::TABLE)
            {
                continue;
            }
            let mut plain = prepared(devices, "");
            let name = format!("{} of {devices}", schedule.faults[0]);
            Arc::make_mut(&mut plain.plan).faults = schedule;
            let (run, records) = run(&plain);
            assert!(run.faults[0].begun, "{name}");
            assert!(run.faults[0].acted > 0, "{name} did nothing");
            assert!(matches!(told(&records)[0].1.event, FaultEvent::Began), "{name}");
            let ended = told(&records)
                .iter()
                .any(|(_, fault)| matches!(fault.event, FaultEvent::Ended { acted } if acted > 0));
            assert!(ended || info.lasts == Lasts::Instant, "{name} did not end");
            // The controller may give up; the world must not.
            let reason = run.ending.reason.unwrap_or_default();
            assert!(!reason.contains("time stands still"), "{name}: {reason}");
            assert!(!reason.contains("without end"), "{name}: {reason}");
            assert_ne!(run.ending.outcome, Outcome::Aborted, "{name}");
            tried += 1;
        }
    }
    assert!(tried > FaultKind::all().len());
}
