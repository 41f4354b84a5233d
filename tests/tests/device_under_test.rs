//! A device under test, whose messages a description states: a power supply in Python, which the plan asks.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::request_and_answer::block;
use harness::{Trial, TrialError};
use record::outcome::Outcome;
use tempfile::TempDir;
use tests::project;

const RIG: &str = r#"title = "A supply in Python and the plan"
[[line]]
name = "uart"
serial = {}
[[node]]
name = "asker"
at = "uart"
tester = true
[[node]]
name = "supply"
at = "uart"
under_test = { command = ["python3", "SUPPLY", "{uart}"] }
described_by = "supply"
"#;

/// A load of 10 Ohm, and answers after 20 ms.
const SUPPLY: &str = r#"
import os, sys, time
port, volts, line = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY), 0.0, b""
while True:
    line += os.read(port, 100)
    while b"\n" in line:
        request, line = line.split(b"\n", 1)
        words = request.decode().split()
        if words[0] == "VOLT":
            volts = float(words[1])
        elif words[0] == "MEAS:VOLT?":
            time.sleep(0.02)
            os.write(port, b"%.3f\n" % volts)
        elif words[0] == "MEAS:CURR?":
            time.sleep(0.02)
            os.write(port, b"%.4f\n" % (volts / 10))
"#;

/// The plan of the page, about this rig.
fn plan() -> String {
    let plan = block("name = \"readings\"").replace("device = \"supply\"", "rig = \"bench\"");
    let plan = plan.replace("signal.", "supply.");
    let property = "\n[[property]]\nname = \"by_ohm\"\n\
        always = \"supply.Current > 1 A -> supply.Voltage > 11.9 V\"\n";
    plan + property
}

fn load(rig: &str, supply: &str, plan: &str) -> (TempDir, Result<Trial, TrialError>) {
    let folder = project::of([("supply.py", supply)]);
    let program = folder.path().join("supply.py").to_string_lossy().into_owned();
    project::write(
        folder.path(),
        [
            ("devices/supply.toml", block("name = \"supply\"")),
            ("rigs/bench.toml", &rig.replace("SUPPLY", &program)),
            ("plan.toml", plan),
        ],
    );
    let trial = project::load(&folder, "plan.toml");
    (folder, trial)
}

fn run(supply: &str) -> (TempDir, harness::TrialRun) {
    let (folder, trial) = load(RIG, supply, &plan());
    let run = trial.unwrap_or_else(|error| panic!("{}", project::why(&error))).run().unwrap();
    (folder, run)
}

#[test]
fn what_it_answers_is_judged() {
    let (_folder, run) = run(SUPPLY);
    assert!(run.passed(), "{run}");
    assert_eq!(run.measurement("voltage").unwrap().observations, 20);
    assert_eq!(run.property("by_ohm").unwrap().held, Some(true));
    assert_eq!(run.summary().notes, Vec::<String>::new());
}

#[test]
fn planted_mistakes_fail() {
    for (right, wrong, named) in [
        ("volts / 10", "volts / 9", "current"),
        ("b\"%.3f\\n\" % volts", "b\"%.3f\\n\" % (volts + 0.02)", "voltage"),
        ("volts = float(words[1])", "pass", "voltage"),
    ] {
        let (_folder, run) = run(&SUPPLY.replace(right, wrong));
        assert!(!run.passed(), "{wrong}: {run}");
        let (low, high) = if named == "current" { (1.199, 1.201) } else { (11.99, 12.01) };
        let value = run.value(named).unwrap();
        assert!(!(low..=high).contains(&value), "{wrong}: {value}");
    }
    let (_folder, silent) = run(&SUPPLY.replace("MEAS:CURR?", "CURR?"));
    assert!(!silent.passed() && silent.value("current").is_none(), "{silent}");
}

/// A value that was set is lost with its command, and whoever asks for it sees that.
#[test]
fn a_campaign_strikes_its_line() {
    let (_folder, trial) = load(RIG, SUPPLY, &plan());
    let found =
        trial.unwrap().campaign().cases(20).faults(&["disconnect"]).must_pass().run().unwrap();
    assert!(!found.smallest().is_empty(), "{found}");
}

#[test]
fn only_a_node_under_test_is_described_by_a_file() {
    let why = |rig: &str| project::why(&load(rig, SUPPLY, &plan()).1.err().unwrap());
    let emulated = RIG.replace("described_by = \"supply\"", "");
    assert!(why(&emulated).contains("nothing is known of what `asker` could send"));
    let tester = RIG.replace("tester = true", "tester = true\ndescribed_by = \"supply\"");
    assert!(why(&tester).contains("`asker` is not under test"), "{}", why(&tester));
    let channel = "isotp = { request_id = 0x7E0, response_id = 0x7E8 }";
    let twice = format!("{RIG}{channel}");
    let told = "`supply`, which describes `supply`, has it";
    assert!(why(&twice).contains(told), "{}", why(&twice));
}

/// Found by a user: such a run was called "timeout", although the device had failed.
#[test]
fn a_limit_of_a_step_says_more_than_that_of_the_plan() {
    let plan = "name = \"plan\"\ntitle = \"\"\nrig = \"bench\"\ntime_limit_s = 2\nsteps = [\n\
        { wait_until = { above = { quantity = \"supply.Voltage\", limit = 1 } }, time_limit_s = 2 },\n]\n\
        [[measurement]]\nname = \"voltage\"\ndoc = \"\"\nquantity = \"supply.Voltage\"\nunit = \"V\"\n\
        check = { all_within = [0, 30] }\n";
    let (_folder, trial) = load(RIG, SUPPLY, plan);
    let run = trial.unwrap_or_else(|error| panic!("{}", project::why(&error))).run().unwrap();
    assert_eq!(run.summary().outcome, Outcome::Failed, "{run}");
    let reason = run.summary().reason.as_deref().unwrap_or_default();
    assert!(reason.contains("steps[0]") && reason.contains("took longer"), "{reason}");
}
