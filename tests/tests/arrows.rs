//! The house rules that no compiler enforces: which room may depend on which, what may read a clock, and how long a
//! file may be.

use std::collections::BTreeMap;
use tests::rooms::{Source, manifest, members, root, sources};
use toml::Table;

/// Rooms that each room may depend on, by folder and by name. A room missing here has no place in the house yet.
const ARROWS: &[(&str, &[&str])] = &[
    ("wire", &[]),
    ("controller", &["wire"]),
    ("emulators", &["wire"]),
    ("described/file", &["wire"]),
    ("described", &["wire", "emulators", "described-file"]),
    ("ports", &["wire"]),
    ("identification", &["wire"]),
    ("evaluation", &["identification"]),
    // What is stated before a run, and its events.
    (
        "harness/plan",
        &["wire", "controller", "emulators", "described", "identification", "ports", "temporal"],
    ),
    ("harness/record", &["wire", "controller", "described", "plan"]),
    // Formulas know no plan: anything with signals can use them.
    ("harness/temporal", &["wire"]),
    // Uses of a record.
    ("harness/judge", &["wire", "controller", "described", "plan", "record", "temporal"]),
    ("harness/dataset", &["controller", "identification", "plan", "record", "bus-log"]),
    ("harness/campaign", &["wire", "emulators", "plan", "record"]),
    (
        "harness/views",
        &["wire", "controller", "identification", "plan", "record", "judge", "campaign"],
    ),
    ("harness/bus-log", &["wire", "record"]),
    // Unsafe code is here and in the next room: C on the other side.
    ("harness/fmu", &["described"]),
    // The library in the FMUs that hil writes: with everything that it knows it goes into each of them.
    ("harness/fmu-device", &["wire", "described"]),
    ("harness/exchange", &["wire", "controller", "described", "plan", "record", "bus-log"]),
    // Programs in virtual time know nothing of plans.
    ("harness/lockstep", &["wire"]),
    // Runs: in virtual time without a port, in real time, and complete.
    (
        "harness/rig",
        &[
            "wire",
            "controller",
            "emulators",
            "described",
            "identification",
            "plan",
            "record",
            "temporal",
            "judge",
            "dataset",
        ],
    ),
    (
        "harness/live",
        &[
            "wire",
            "controller",
            "emulators",
            "described",
            "lockstep",
            "ports",
            "plan",
            "record",
            "judge",
            "rig",
        ],
    ),
    (
        "harness",
        &[
            "wire",
            "controller",
            "emulators",
            "described",
            "identification",
            "live",
            "ports",
            "rig",
            "plan",
            "record",
            "temporal",
            "judge",
            "dataset",
            "campaign",
            "views",
            "bus-log",
            "fmu",
        ],
    ),
    ("harness/campaign-nats", &["wire", "plan", "record", "campaign", "harness"]),
    (
        "harness/hil",
        &[
            "wire",
            "controller",
            "emulators",
            "described",
            "identification",
            "ports",
            "plan",
            "record",
            "judge",
            "dataset",
            "campaign",
            "views",
            "bus-log",
            "fmu",
            "fmu-device",
            "exchange",
            "campaign-nats",
            "harness",
            "live",
            "rig",
        ],
    ),
    ("harness/hil-nats", &["hil"]),
    (
        "tests",
        &[
            "wire",
            "controller",
            "emulators",
            "identification",
            "plan",
            "record",
            "judge",
            "dataset",
            "campaign",
            "bus-log",
            "described",
            "fmu",
            "exchange",
            "harness",
            "hil",
            "rig",
        ],
    ),
    // Usable by tests of any room.
    ("tests/skips", &[]),
    // Depend on the harness alone, as a user's crate does.
    ("examples/battery-pack", &["harness"]),
    ("examples/rust-tests", &["harness"]),
];

/// Additional dependencies for a room's tests: runs to read back.
const ARROWS_OF_TESTS: &[(&str, &str)] = &[
    ("harness/dataset", "harness"),
    ("harness/exchange", "harness"),
    ("harness/fmu", "wire"),
    ("harness/fmu-device", "fmu"),
    ("harness/hil-nats", "campaign"),
    ("harness/hil-nats", "campaign-nats"),
    ("harness/hil-nats", "harness"),
];

/// Rooms that may depend on both the controller and the emulators.
const WITH_BOTH: [&str; 6] =
    ["harness/plan", "harness/rig", "harness/live", "harness", "harness/hil", "tests"];

/// Maximum lines of a file: a longer one is hard to keep in mind.
const LINES_MAX: usize = 400;

/// Not to be used where time is an argument.
const CLOCKS: [&str; 4] = ["std::time", "Instant::", "SystemTime", "thread::sleep"];

/// Folders and files where time is an argument.
const TIMELESS: [&str; 14] = [
    "wire/src/",
    "controller/src/",
    "emulators/src/",
    "described/src/",
    "harness/judge/src/",
    "harness/plan/src/",
    "harness/record/src/",
    "harness/temporal/src/",
    "harness/views/src/report/",
    "harness/campaign/src/space.rs",
    "harness/campaign/src/shrink.rs",
    "harness/src/run.rs",
    "harness/src/run/prepared.rs",
    "harness/rig/src/",
];

/// Files with a clock: a thread that flushes records periodically, and a test that measures a duration.
const WITH_A_CLOCK: [&str; 2] = ["harness/record/src/kept.rs", "harness/record/src/tests.rs"];

/// Lists the crates that a manifest names for any target, with or without those for tests.
fn dependencies(manifest: &Table, of_tests: bool) -> Vec<String> {
    let mut found = Vec::new();
    for (key, value) in manifest {
        match value {
            toml::Value::Table(table) if key.ends_with("dependencies") => {
                let is_wanted = key.starts_with("dev-") == of_tests;
                found.extend(table.keys().filter(|_| is_wanted).cloned());
            }
            toml::Value::Table(table) => found.extend(dependencies(table, of_tests)),
            _ => {}
        }
    }
    found
}

/// A room has the name of its folder.
fn name(folder: &str) -> &str {
    folder.rsplit('/').next().unwrap_or(folder)
}

#[test]
fn rooms_know_only_the_rooms_below_them() {
    let members = members();
    let allowed: BTreeMap<_, _> = ARROWS.iter().copied().collect();
    for room in &members {
        let Some(allowed) = allowed.get(room.as_str()) else {
            panic!("the room {room} has no arrows here");
        };
        for of_tests in [false, true] {
            for dependency in dependencies(&manifest(room), of_tests) {
                let is_room = members.iter().any(|member| name(member) == dependency);
                let is_allowed = allowed.contains(&dependency.as_str())
                    || (of_tests && is_of_tests(room, &dependency));
                assert!(!is_room || is_allowed, "{room} must not know {dependency}");
            }
        }
    }
}

fn is_of_tests(room: &str, dependency: &str) -> bool {
    ARROWS_OF_TESTS.contains(&(room, dependency))
        // A room asks for features of itself.
        || dependency == name(room)
        || dependency == "skips"
}

#[test]
fn truth_and_belief_are_seen_together_where_they_must_be() {
    for room in members() {
        let known = dependencies(&manifest(&room), false);
        let both = ["emulators", "controller"].iter().all(|name| known.iter().any(|k| k == name));
        assert_eq!(both, WITH_BOTH.contains(&room.as_str()), "{room}");
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
        let own = format!("{room}/src/");
        for Source { path, text } in sources(&own, "rs") {
            assert!(!text.contains("ports::"), "{path} knows ports");
        }
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
    // Otherwise a renamed place would no longer be checked.
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
