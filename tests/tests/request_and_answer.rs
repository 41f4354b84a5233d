//! Answers that look the same, told apart by their requests: the devices and the plan of `docs/request-and-answer.md`.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use harness::{Trial, TrialError};
use tempfile::TempDir;
use tests::project;

const PAGE: &str = include_str!("../../docs/request-and-answer.md");

/// A block of the page by its first line.
pub fn block(begins: &str) -> &'static str {
    let mut blocks = PAGE.split("```toml\n").filter_map(|rest| rest.split_once("```"));
    blocks.find_map(|(block, _)| block.starts_with(begins).then_some(block)).unwrap()
}

/// The drive turns at 100 rpm once its time constant is long over; a current of 0.2 A then.
const DRIVE: &str = r#"
name = "plan"
title = "The drive turns as fast as it was told to"
device = "drive"
steps = [
  { send = { message = "SetSpeed", set = { Setpoint = 100 } } },
  { wait = { duration_s = 6 } },
  { repeat = { times = 20, steps = [
    { send = { message = "ReadSpeed" } },
    { wait = { duration_s = 0.05 } },
    { send = { message = "ReadCurrent" } },
    { wait = { duration_s = 0.05 } },
  ] } },
]
[[measurement]]
name = "speed"
doc = "As set"
quantity = "signal.Speed"
unit = "rpm"
observations_min = 5
check = { all_within = [99, 101] }
[[measurement]]
name = "current"
doc = "That of a speed that does not change"
quantity = "signal.Current"
unit = "A"
observations_min = 5
check = { all_within = [0.19, 0.21] }
[[property]]
name = "never_mixed"
always = "device.Current < 1 and device.Speed > 50"
"#;

fn load(plan: &str) -> (TempDir, Result<Trial, TrialError>) {
    let folder = project::of([
        ("devices/drive.toml", block("name = \"drive\"")),
        ("devices/supply.toml", block("name = \"supply\"")),
        ("plan.toml", plan),
    ]);
    let trial = project::load(&folder, "plan.toml");
    (folder, trial)
}

fn run(plan: &str) -> (TempDir, harness::TrialRun) {
    let (folder, trial) = load(plan);
    let run = trial.unwrap_or_else(|error| panic!("{}", project::why(&error))).run().unwrap();
    (folder, run)
}

#[test]
fn the_plan_of_the_page_passes() {
    let (_folder, run) = run(block("name = \"readings\""));
    assert!(run.passed(), "{run}");
    assert_eq!(run.value("voltage"), Some(12.0));
    assert_eq!(run.value("current"), Some(1.2));
}

#[test]
fn registers_without_their_address_are_those_that_were_asked_for() {
    let (_folder, run) = run(DRIVE);
    assert!(run.passed(), "{run}");
    assert_eq!(run.measurement("speed").unwrap().observations, 20);
    assert_eq!(run.property("never_mixed").unwrap().held, Some(true));
}

/// Of the answers that come through, each is that of its request.
#[test]
fn lost_requests_and_answers_mix_nothing_up() {
    for (seed, what) in [
        "drop = { loss_percent = 3 }",
        "flip = { flip_percent = 3 }",
        "insert = { insert_percent = 3 }",
        "framing_slip = { slip_percent = 20 }",
    ]
    .into_iter()
    .enumerate()
    {
        let fault =
            format!("[[fault]]\ntarget = \"device\"\nwhat = {{ {what} }}\nwhen = {{ at_s = 6 }}\n");
        let (_folder, trial) = load(&format!("{DRIVE}{fault}"));
        let trial = trial.unwrap_or_else(|error| panic!("{what}: {}", project::why(&error)));
        let run = trial.with_seed(seed as u64).run().unwrap();
        assert!(run.passed(), "{what}: {run}");
        let heard = run.measurement("speed").unwrap().observations;
        assert!((5..20).contains(&heard), "{what}: {heard}");
    }
}

/// Found by a user: no plan could demand that a serial line is sound.
const STRANGE: &str = r#"
[[measurement]]
name = "strange"
doc = "Bytes outside of messages, and messages with a wrong checksum"
quantity = "unexpected.device"
unit = "1"
check = { all_within = { at_most = 0 } }
"#;

#[test]
fn a_plan_judges_the_damage_of_a_serial_line() {
    let flips = "[[fault]]\ntarget = \"device\"\nwhat = { flip = { flip_percent = 3 } }\n";
    for (fault, is_sound) in [("", true), (flips, false)] {
        let (_folder, run) =
            run(&DRIVE.replacen("[[property]]", &format!("{STRANGE}{fault}[[property]]"), 1));
        let strange = run.measurement("strange").unwrap();
        assert_eq!(strange.value == Some(0.0), is_sound, "{run}");
        assert_eq!(strange.verdict.is_acceptable(), is_sound, "{run}");
    }
}

#[test]
fn an_answer_without_an_open_request_is_no_message() {
    let both = DRIVE.replace(
        "{ wait = { duration_s = 0.05 } },\n    { send = { message = \"ReadCurrent\"",
        "{ send = { message = \"ReadCurrent\"",
    );
    let (_folder, run) = run(&format!("{both}{STRANGE}"));
    assert_eq!(run.value("strange"), Some(140.0));
    let notes = run.summary().notes.join("\n");
    assert!(notes.contains("bytes or frames outside of any message: 140"), "{notes}");
    assert_eq!(run.measurement("speed").unwrap().observations, 0);
}

#[test]
fn no_fault_strikes_one_of_them_alone() {
    let fault = "[[fault]]\ntarget = \"device.SpeedIs\"\nwhat = { drop = { loss_percent = 10 } }\nwhen = { at_s = 1 }\n";
    let (_folder, trial) = load(&format!("{DRIVE}{fault}"));
    let why = project::why(&trial.err().unwrap());
    assert!(
        why.contains("`SpeedIs` looks like another answer: no fault strikes it alone"),
        "{why}"
    );
}

#[test]
fn answers_that_nothing_tells_apart_are_refused() {
    let supply = block("name = \"supply\"");
    let same = supply.replace("answers = \"AskCurrent\"", "answers = \"AskVoltage\"");
    let queue = "text = \"MEAS:CURR?\\n\"\nwhile_answering = \"queue\"";
    let waits = supply.replace("text = \"MEAS:CURR?\\n\"", queue);
    let unasked = supply.replace("answers = \"AskCurrent\"\ndelay_s = 0.02", "period_s = 1");
    for (device, told) in [
        (
            same,
            "`VoltageIs` and `CurrentIs` are alike but for their numbers, and answer the same request",
        ),
        (waits, "are alike but for their numbers, and `AskCurrent` can wait in a queue"),
        (unasked, "`VoltageIs` and `CurrentIs` are alike but for their numbers"),
    ] {
        assert_ne!(device, supply);
        let folder = project::of([
            ("devices/supply.toml", device.as_str()),
            ("plan.toml", block("name = \"readings\"")),
        ]);
        let why = project::why(&project::load(&folder, "plan.toml").err().unwrap());
        assert!(why.contains(told), "{why}");
    }
}
