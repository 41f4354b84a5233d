//! The plans that the identification proposes can be read, and carried out on the shipped benches.

use harness::run::{Prepared, simulate};
use identification::dataset::Kind;
use identification::experiment::plans;
use plan::made::Made;
use plan::{Action, Plan, Step};
use record::outcome::Outcome;
use record::sink::NullSink;
use rig::operator::Answers;
use std::sync::Arc;
use wire::time::Span;

fn texts(kind: Kind) -> Vec<(String, String)> {
    plans(kind, &[("supply \"A\"\n", "V", 11.5, 12.5)])
}

fn menu(kind: Kind) -> Vec<(String, Plan)> {
    texts(kind)
        .into_iter()
        .map(|(name, text)| {
            let plan = Plan::parse(&format!("{name}.toml"), &text)
                .unwrap_or_else(|error| panic!("{text}\n{:?}", miette::Report::new(error)));
            assert_eq!(plan.name.as_str(), name);
            (name, plan)
        })
        .collect()
}

/// Each step once, logs of seconds: the menu takes days of bench time otherwise.
fn shorten(steps: &mut [Step]) {
    const LOG: Span = Span::from_secs(10);
    for step in steps {
        match &mut step.action {
            Action::Repeat(repeat) => {
                (repeat.times, repeat.period) = (1, None);
                shorten(&mut repeat.steps);
            }
            Action::Sweep(sweep) => {
                sweep.values.truncate(2);
                shorten(&mut sweep.steps);
            }
            Action::Log(log) => log.duration = log.duration.min(LOG),
            _ => {}
        }
    }
}

#[test]
fn every_plan_of_the_menu_is_right() {
    for (kind, at_least) in [(Kind::Turns, 10), (Kind::Laps, 8)] {
        let menu = menu(kind);
        assert!(menu.len() >= 2 * at_least);
        for (name, plan) in &menu {
            assert!(!plan.measurements.is_empty(), "{name}");
        }
    }
    assert_eq!(menu(Kind::Turns), menu(Kind::Series));
    assert_eq!(menu(Kind::Laps), menu(Kind::Odometry));
}

#[test]
fn every_plan_of_the_menu_runs() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [texts(Kind::Turns), texts(Kind::Laps)].concat() {
        let file = folder.path().join(format!("{name}.toml"));
        std::fs::write(&file, text).unwrap();
        let mut prepared = Prepared::load(file.to_str().unwrap(), &Made::default()).unwrap();
        let mut plan = Plan::clone(&prepared.plan);
        shorten(&mut plan.steps);
        prepared.plan = Arc::new(plan);
        let on_table =
            prepared.plan.devices.as_ref().is_some_and(|name| name.as_str().contains("table"));
        let run = simulate(&prepared, 1, &Answers::default(), &mut NullSink, &mut |_| true);
        assert_eq!(run.ending.outcome, Outcome::Passed, "{name}: {:?}", run.ending);
        if on_table {
            for direction in [-1.0, 1.0] {
                let turned = run.observations.of("table.angle").any(|one| {
                    one.tag("direction") == Some(direction) && one.tag("temperature").is_some()
                });
                assert!(turned, "{name} turns both ways and tells the temperature");
            }
        }
    }
}
