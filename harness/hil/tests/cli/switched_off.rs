//! A program under test that a step switches off and on.

use super::programs::{PLAN, project};
use std::fs;

/// Found by a user: the rerun left the program on, and blamed it.
#[test]
fn a_program_that_a_step_switches_off_is_switched_off_in_its_rerun() {
    let hil = project("pass");
    let steps = "{ wait = { duration_s = 1 } }, { power_cycle = { device = \"beat\", off_s = 0.5 } }, { wait = { duration_s = 1 } }";
    let plan =
        PLAN.replace("{ wait = { duration_s = 3 } }", steps).replace("_min = 20", "_min = 2");
    fs::write(hil.path("beats.toml"), plan).unwrap();
    hil.run(&["run", "./beats.toml", "--record", "full", "--out", "out"]).exits(0);
    let again = hil.run(&["rerun", "out"]).exits(0).out;
    assert!(again.contains("the same: "), "{again}");
}
