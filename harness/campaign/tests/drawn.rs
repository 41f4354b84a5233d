//! What the faults of a campaign strike, and when.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use campaign::{Course, Guided, Random, Search, Space, Targets};
use plan::Plan;
use plan::faults::{Lasts, LineKind, Lines, Said, Target, When};
use std::collections::BTreeSet;
use wire::time::Span;

const PLAN: &str = r#"
name = "p"
title = ""
rig = "r"
steps = [
    { wait = { duration_s = 1 }, label = "idle" },
    { send = { message = "Request", every_s = 0.1 } },
    { set_parameter = { parameter = "cells.offset", value = 1 }, label = "offset" },
    { repeat = { times = 2, steps = [{ wait = { duration_s = 1 } }] }, label = "rounds" },
    { stop_sending = "Request" },
]

[[property]]
name = "on"
always = "cells.State > 0"
"#;

/// Cells and a manager, which is under test, on one bus.
fn lines() -> Lines {
    let target = |name: &str| (Target::named(name).unwrap(), LineKind::Can);
    let said = |node: &str, message: &str| Said {
        node: node.to_owned(),
        message: message.to_owned(),
        line: LineKind::Can,
        signals: vec!["State".to_owned(), format!("{message}Level")],
        ranges: vec![(0.0, 7.0); 2],
        counter: true,
        checksum: true,
        never_alone: None,
    };
    Lines {
        robot: None,
        host: true,
        nodes: ["cells", "manager", "bus"].map(target).to_vec(),
        shared: vec![Target::named("bus").unwrap()],
        powered: ["cells", "manager"].map(|name| Target::named(name).unwrap()).to_vec(),
        said: vec![said("cells", "A"), said("cells", "B"), said("manager", "Limit")],
    }
}

fn space(only: &[&str], names: &[&str]) -> Space {
    space_of(only, names, Span::from_secs(3))
}

fn space_of(only: &[&str], names: &[&str], course: impl Into<Course>) -> Space {
    let plan = Plan::parse("p.toml", PLAN).unwrap();
    let [only, names] = [only, names].map(|all| all.iter().map(|&one| one.to_owned()).collect());
    let (only, names): (Vec<String>, Vec<String>) = (only, names);
    let targets = Targets::named(&names, &lines(), vec!["manager".to_owned()]).unwrap();
    Space::among(&plan, lines(), course, 4, &only, &targets)
}

fn struck(space: &Space) -> BTreeSet<&str> {
    space.kinds().iter().map(|(target, _)| target.name()).collect()
}

/// Found by a user: a right program broke its own properties, because its messages were changed behind it.
#[test]
fn what_the_device_under_test_says_is_struck_only_on_request() {
    let all = space(&[], &[]);
    let struck = struck(&all);
    assert!(struck.contains("manager") && struck.contains("cells.A"), "{struck:?}");
    assert!(struck.iter().all(|name| !name.starts_with("manager.")), "{struck:?}");
}

#[test]
fn faults_strike_the_targets_that_were_asked_for() {
    let of = |only: &[&str], names: &[&str]| {
        let space = space(only, names);
        struck(&space).into_iter().collect::<Vec<_>>().join(" ")
    };
    assert_eq!(of(&[], &["bus"]), "bus");
    assert_eq!(of(&[], &["manager", "host"]), "host manager");
    assert_eq!(
        of(&["signal_value", "drop"], &["cells"]),
        "cells cells.A.ALevel cells.A.State cells.B.BLevel cells.B.State"
    );
    assert_eq!(of(&["signal_value"], &["cells.A"]), "cells.A.ALevel cells.A.State");
    assert_eq!(of(&["signal_value"], &["cells.ALevel"]), "cells.A.ALevel");
    assert_eq!(of(&["stuck_counter", "drop"], &["manager.Limit"]), "manager.Limit");
    // A supply is not a line; that of the program under test is cut on request.
    assert_eq!(of(&["restart"], &[]), "cells");
    assert_eq!(of(&["restart"], &["manager", "bus"]), "manager");
}

#[test]
fn a_misspelt_target_is_refused_with_a_proposal() {
    for (wrong, right) in
        [("celsl", "`cells`"), ("cells.Aa", "cells."), ("x y", "a node or a line")]
    {
        let unknown = Targets::named(&[wrong.to_owned()], &lines(), Vec::new()).unwrap_err();
        assert!(unknown.help.contains(right), "{wrong}: {unknown:?}");
    }
}

/// Found by a user: faults waited for steps that take no time, and could not act.
#[test]
fn no_fault_is_drawn_in_a_step_that_takes_no_time() {
    let space = space(&[], &[]);
    let phases: Vec<&str> = space.phases().iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(phases, ["idle", "repeat", "rounds", "wait"]);
    let searches: [Box<dyn Search>; 2] =
        [Box::new(Guided::new(&space, 1)), Box::new(Random::new(&space, 1))];
    for mut search in searches {
        for fault in (0..200).flat_map(|_| search.next().schedule.faults) {
            let phase = fault.when.phase().map(|(name, _)| name.as_str());
            assert!(phase.is_none_or(|phase| phases.contains(&phase)), "{fault:?}");
        }
    }
}

/// Found by a user: in steps of 0.03 to 4 s, faults began up to 10 s after the beginning, in another step.
#[test]
fn a_fault_in_a_phase_begins_before_its_end() {
    let ms = |all: &[i64]| all.iter().map(|&ms| Span::from_millis(ms)).collect::<Vec<_>>();
    let lengths = [("idle", ms(&[30])), ("wait", ms(&[30, 2_000, 900])), ("rounds", ms(&[0, 0]))];
    let phases = lengths.map(|(phase, all)| (phase.to_owned(), all)).into();
    let space = space_of(&[], &[], Course { lasted: Span::from_secs(3), phases });
    // What took no time is left out; of a repeat that is not known, anything may be.
    let names: Vec<&str> = space.phases().iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["idle", "repeat", "wait"]);
    let searches: [Box<dyn Search>; 2] =
        [Box::new(Guided::new(&space, 1)), Box::new(Random::new(&space, 1))];
    for mut search in searches {
        let mut latest = [0; 4];
        for fault in (0..400).flat_map(|_| search.next().schedule.faults) {
            let When::Step { phase, number, after } = fault.when else { continue };
            let place = match phase.as_str() {
                "idle" => 0,
                "wait" => number as usize,
                _ => continue,
            };
            latest[place] = after.as_nanos().max(latest[place]);
        }
        for (latest, most) in latest.into_iter().zip(ms(&[30, 30, 2_000, 900])) {
            let most = most.as_nanos();
            assert!(latest < most && latest > most / 2, "{latest} of {most}");
        }
    }
}

/// Found by a user: a plan stalled for 3599.9999999999995 s.
#[test]
fn severities_are_numbers_that_a_person_would_write() {
    let space = space(&[], &[]);
    let mut search = Random::new(&space, 1);
    for fault in (0..400).flat_map(|_| search.next().schedule.faults) {
        let (severity, info) = (fault.what.severity(), fault.what.info());
        let text = severity.to_string();
        let is_short = match info.lasts {
            Lasts::Itself => text.split_once('.').is_none_or(|(_, rest)| rest.len() <= 3),
            _ => format!("{severity:.3e}").parse() == Ok(severity),
        };
        assert!(is_short || !fault.what.is_graded(), "{fault:?}");
    }
}
