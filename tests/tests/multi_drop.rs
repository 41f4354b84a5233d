//! Several devices on one serial line (RS-485): two of the drives of `docs/request-and-answer.md`, at addresses of their own.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::request_and_answer::block;
use harness::{Trial, TrialError};
use tempfile::TempDir;
use tests::project;

const RIG: &str = r#"
title = "Two drives and a master"
[[line]]
name = "rs485"
serial = {}
[[node]]
name = "left"
at = "rs485"
emulate = "left"
[[node]]
name = "right"
at = "rs485"
emulate = "right"
[[node]]
name = "master"
at = "rs485"
tester = true
"#;

/// Each is set to its own speed, and read in turns.
const PLAN: &str = r#"
name = "plan"
title = "Each drive turns as fast as it was told to"
rig = "drives"
steps = [
  { send = { message = "left.SetSpeed", set = { Setpoint = 100 } } },
  { wait = { duration_s = 0.05 } },
  { send = { message = "right.SetSpeed", set = { Setpoint = -40 } } },
  { wait = { duration_s = 6 } },
  { repeat = { times = 20, steps = [
    { send = { message = "left.ReadSpeed" } },
    { wait = { duration_s = 0.05 } },
    { send = { message = "right.ReadSpeed" } },
    { wait = { duration_s = 0.05 } },
  ] } },
]
[[measurement]]
name = "left"
doc = "As set"
quantity = "left.Speed"
unit = "rpm"
observations_min = 5
check = { all_within = [99, 101] }
[[measurement]]
name = "right"
doc = "As set"
quantity = "right.Speed"
unit = "rpm"
observations_min = 5
check = { all_within = [-41, -39] }
"#;

fn drive(address: u8) -> String {
    let one = block("name = \"drive\"");
    one.replace("start = [1,", &format!("start = [{address},"))
}

fn load(rig: &str, right: &str, plan: &str) -> (TempDir, Result<Trial, TrialError>) {
    let folder = project::of([
        ("devices/left.toml", &*drive(1)),
        ("devices/right.toml", right),
        ("rigs/drives.toml", rig),
        ("plan.toml", plan),
    ]);
    let trial = project::load(&folder, "plan.toml");
    (folder, trial)
}

fn run(right: &str, plan: &str) -> harness::TrialRun {
    let (_folder, trial) = load(RIG, right, plan);
    trial.unwrap_or_else(|error| panic!("{}", project::why(&error))).run().unwrap()
}

#[test]
fn each_answers_what_it_is_asked() {
    let run = run(&drive(2), PLAN);
    assert!(run.passed(), "{run}");
    for name in ["left", "right"] {
        assert_eq!(run.measurement(name).unwrap().observations, 20, "{name}");
    }
    assert!(run.summary().notes.is_empty(), "{:?}", run.summary().notes);
}

#[test]
fn a_fault_of_one_leaves_the_other_alone() {
    let fault = "[[fault]]\ntarget = \"left\"\nwhat = { disconnect = { for_s = 100 } }\nwhen = { at_s = 6.5 }\n";
    let run = run(&drive(2), &format!("{PLAN}{fault}"));
    let heard = |name| run.measurement(name).unwrap().observations;
    assert!((1..20).contains(&heard("left")), "{}", heard("left"));
    assert_eq!(heard("right"), 20);
}

/// The second request is on the line while the first is answered.
#[test]
fn what_two_send_at_the_same_time_collides() {
    let both = PLAN.replace(
        "{ wait = { duration_s = 0.05 } },\n    { send = { message = \"right.ReadSpeed\"",
        "{ send = { message = \"right.ReadSpeed\"",
    );
    assert_ne!(both, PLAN);
    let run = run(&drive(2), &both);
    let notes = run.summary().notes.join("\n");
    assert!(notes.contains("20 times two nodes sent at the same time on rs485"), "{notes}");
    assert_eq!(run.measurement("left").unwrap().observations, 0, "{notes}");
}

#[test]
fn two_of_one_address_answer_at_the_same_time() {
    let plan = PLAN.replace("right.", "left.").replace("left.S", "S").replace("left.R", "R");
    let run = run(&drive(1), &plan.replace("quantity = \"S", "quantity = \"left.S"));
    let notes = run.summary().notes.join("\n");
    assert!(notes.contains("two nodes sent at the same time on rs485"), "{notes}");
}

#[test]
fn what_cannot_share_a_line_is_refused() {
    let refused = |rig: &str, right: &str| {
        let (_folder, trial) = load(rig, right, PLAN);
        project::why(&trial.err().unwrap())
    };
    let other = drive(2).replace("baud = 19200", "baud = 9600");
    let expected = "`right` and `left` have other settings of one line";
    assert!(refused(RIG, &other).contains(expected), "{}", refused(RIG, &other));
    let alike = drive(1).replace("start = [1, 3, 0, 100, 0, 1]", "start = [1, 3, 0, 100]");
    let expected = "`ReadSpeed` of `left` and `ReadSpeed` of `right` look the same";
    assert!(refused(RIG, &alike).contains(expected), "{}", refused(RIG, &alike));
    let attached = "under_test = { attached = true }\ndescribed_by";
    let tested = RIG.replace("emulate", attached);
    let expected = "a second node under test on the serial line `rs485` of 3 ends";
    assert!(refused(&tested, &drive(2)).contains(expected), "{}", refused(&tested, &drive(2)));
}
