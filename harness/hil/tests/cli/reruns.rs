//! Reruns of a program under test.

use super::hil::Hil;
use super::programs::{PLAN, project};
use std::fs;

/// A run of these steps with the program, recorded in `out`.
fn recorded(steps: &str) -> Hil {
    let hil = project("pass");
    let plan =
        PLAN.replace("{ wait = { duration_s = 3 } }", steps).replace("_min = 20", "_min = 2");
    fs::write(hil.path("beats.toml"), plan).unwrap();
    hil.run(&["run", "./beats.toml", "--record", "full", "--out", "out"]).exits(0);
    hil
}

/// The plan ends in the nanosecond in which a frame of the program arrives.
#[test]
fn what_is_under_way_at_the_end_of_a_run_is_the_same_in_its_rerun() {
    let hil = recorded(
        "{ wait_until = { above = { quantity = \"beat.Count\", limit = 0.5 } } }, { wait = { duration_s = 0.5 } }",
    );
    let shown = hil.run(&["show", "out"]).exits(0).out;
    let at = |what: &str| {
        let line = shown.lines().find(|line| line.contains(what));
        line.and_then(|line| line.split_whitespace().next())
    };
    assert_eq!(at("frame 123#06"), at("end steps[1]"), "{shown}");
    let again = hil.run(&["rerun", "out"]).exits(0).out;
    assert!(again.contains("the same: 6 outputs"), "{again}");
}

/// Found by a user: the rerun left the program on, and blamed it.
#[test]
fn a_program_that_a_step_switches_off_is_switched_off_in_its_rerun() {
    let hil = recorded(
        "{ wait = { duration_s = 1 } }, { power_cycle = { device = \"beat\", off_s = 0.5 } }, { wait = { duration_s = 1 } }",
    );
    let again = hil.run(&["rerun", "out"]).exits(0).out;
    assert!(again.contains("the same: "), "{again}");
}

/// Found by a user: all outputs were the same, and the exit status was 1.
#[test]
fn a_program_that_exits_as_in_the_run_is_the_same() {
    let hil = project("if count == 20: sys.exit('no more beats')");
    hil.run(&["run", "beats.toml", "--record", "full", "--out", "out"]).exits(1);
    let again = hil.run(&["rerun", "out"]).exits(0).out;
    assert!(again.contains("the same: 19 outputs"), "{again}");
    assert!(again.contains("it ended as in the run: `beat`, which is under test, "), "{again}");

    let program = fs::read_to_string(hil.path("beat.py")).unwrap();
    for (end, told) in [
        ("sys.exit('no power')", "it ended otherwise than in the run: recorded `beat`"),
        ("time.sleep(1e6)", "it did not end early, as it did in the run: recorded `beat`"),
    ] {
        fs::write(hil.path("beat.py"), program.replace("sys.exit('no more beats')", end)).unwrap();
        let other = hil.run(&["rerun", "out"]).exits(1).out;
        assert!(other.contains("the same: 19 outputs") && other.contains(told), "{other}");
    }
}
