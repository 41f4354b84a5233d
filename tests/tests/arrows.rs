//! The house rules that no compiler keeps: which room may know which, who may read a clock, and how
//! long a file may be.

use std::collections::BTreeMap;
use tests::rooms::{Source, root, sources};
use toml::Table;

/// Which rooms each room may depend on. A room that is not here has no place in the house yet.
const ARROWS: &[(&str, &[&str])] = &[
    ("wire", &[]),
    ("controller", &["wire"]),
    ("emulators", &["wire"]),
    ("described", &["wire", "emulators"]),
    ("identification", &["wire"]),
    ("evaluation", &["identification"]),
    ("harness", &["wire", "controller", "emulators", "described", "identification"]),
    ("tests", &["wire", "controller", "emulators", "described", "identification", "harness"]),
    // What tests of any room may use.
    ("tests/skips", &[]),
    // As somebody else's crate would: through the harness alone.
    ("examples/rust-tests", &["harness"]),
];

/// A file that a person can no longer hold in mind.
const LINES_MAX: usize = 800;

/// What nobody mentions where time is an argument.
const CLOCKS: [&str; 4] = ["std::time", "Instant::", "SystemTime", "thread::sleep"];

/// Folders and files where time is an argument.
const TIMELESS: [&str; 15] = [
    "wire/src/",
    "controller/src/",
    "emulators/src/",
    "described/src/",
    "harness/src/checks/",
    "harness/src/engine/",
    "harness/src/link/",
    "harness/src/plan/",
    "harness/src/record/",
    "harness/src/report/",
    "harness/src/run.rs",
    "harness/src/world/bench.rs",
    "harness/src/world/described/",
    "harness/src/world/lines.rs",
    "harness/src/world/simulated.rs",
];

/// They have a clock: the controller's shell, and a test that takes the time of something.
const WITH_A_CLOCK: [&str; 2] = ["controller/src/bin/", "harness/src/record/tests.rs"];

fn manifest(folder: &str) -> Table {
    let path = root().join(folder).join("Cargo.toml");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path:?}: {e}"));
    text.parse().unwrap_or_else(|e| panic!("{path:?}: {e}"))
}

fn members() -> Vec<String> {
    let workspace = manifest("");
    let members = workspace["workspace"]["members"].as_array().expect("members are a list");
    members.iter().map(|member| member.as_str().expect("a path").to_owned()).collect()
}

/// Every crate that a manifest names, for whatever purpose and on whatever target.
fn dependencies(manifest: &Table) -> Vec<String> {
    let mut found = Vec::new();
    for (key, value) in manifest {
        match value {
            toml::Value::Table(table) if key.ends_with("dependencies") => {
                found.extend(table.keys().cloned());
            }
            toml::Value::Table(table) => found.extend(dependencies(table)),
            _ => {}
        }
    }
    found
}

#[test]
fn rooms_know_only_the_rooms_below_them() {
    let members = members();
    let allowed: BTreeMap<_, _> = ARROWS.iter().copied().collect();
    for room in &members {
        let Some(allowed) = allowed.get(room.as_str()) else {
            panic!("the room {room} has no arrows here");
        };
        for dependency in dependencies(&manifest(room)) {
            let is_room = members.contains(&dependency);
            assert!(
                !is_room || allowed.contains(&dependency.as_str()),
                "{room} must not know {dependency}"
            );
        }
    }
}

#[test]
fn only_the_harness_and_its_tests_see_truth_and_belief_together() {
    for room in members() {
        let known = dependencies(&manifest(&room));
        let both = ["emulators", "controller"].iter().all(|name| known.iter().any(|k| k == name));
        assert_eq!(both, room == "harness" || room == "tests", "{room}");
    }
}

#[test]
fn what_runs_on_a_microcontroller_needs_no_std() {
    for room in ["wire", "controller"] {
        let library = std::fs::read_to_string(root().join(room).join("src/lib.rs"))
            .unwrap_or_else(|e| panic!("{room}: {e}"));
        assert!(library.lines().any(|line| line == "#![no_std]"), "{room}");
        // `std` may be named in tests; `alloc` nowhere.
        assert!(!library.contains("extern crate alloc"), "{room} allocates");
    }
}

fn timeless() -> Vec<Source> {
    let mut found = Vec::new();
    for room in ["wire", "controller", "emulators", "described", "harness"] {
        found.extend(sources(room, "rs"));
    }
    found.retain(|source| {
        TIMELESS.iter().any(|place| source.path.starts_with(place))
            && !WITH_A_CLOCK.iter().any(|place| source.path.starts_with(place))
    });
    found
}

#[test]
fn nobody_reads_a_clock_where_time_is_an_argument() {
    let sources = timeless();
    // A place that was renamed would otherwise be watched no longer.
    for place in TIMELESS {
        assert!(sources.iter().any(|source| source.path.starts_with(place)), "no {place}");
    }
    for Source { path, text } in sources {
        for (number, line) in text.lines().enumerate() {
            for clock in CLOCKS {
                assert!(!line.contains(clock), "{path}:{}: {line}", number + 1);
            }
        }
    }
}

#[test]
fn what_runs_twice_alike_iterates_over_nothing_without_order() {
    for Source { path, text } in timeless() {
        for unordered in ["HashMap", "HashSet"] {
            assert!(!text.contains(unordered), "{path} has a {unordered}");
        }
    }
}

#[test]
fn a_file_can_be_held_in_mind() {
    for room in members() {
        for Source { path, text } in sources(&room, "rs") {
            let lines = text.lines().count();
            assert!(lines <= LINES_MAX, "{path} has {lines} lines, expected at most {LINES_MAX}");
        }
    }
}
