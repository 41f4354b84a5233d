//! A node that only answers: its first answer is judged, and what is under way at the end of a plan is not.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use harness::TrialRun;
use tests::project;

/// Acknowledges what was set, one more than that.
const DRIVE: &str = r#"
name = "drive"
title = "A drive"
[serial]
baud = 115_200
[signal.Setpoint]
expression = "Set.Sp + 1"
[[message]]
name = "Set"
sent_by = "host"
text = "SET {Sp:.0}\n"
fields = [{ name = "Sp", unit = "rpm", minimum = 0, maximum = 3000 }]
[[message]]
name = "Ack"
sent_by = "device"
text = "ACK {Setpoint:.0}\n"
answers = "Set"
fields = [{ name = "Setpoint", unit = "rpm", minimum = 0, maximum = 4000 }]
"#;

const STATUS: &str = r#"
[signal.Alive]
expression = "1"
[[message]]
name = "Status"
sent_by = "device"
text = "ALIVE {Alive:.0}\n"
fields = [{ name = "Alive" }]
period_s = 0.05
"#;

const RIG: &str = r#"
[[line]]
name = "uart"
serial = {}
[[node]]
name = "drive"
at = "uart"
emulate = "drive"
[[node]]
name = "desk"
at = "uart"
tester = true
"#;

/// Counts every 10 ms, to 199 and again from 0.
pub const BEAT: &str = r#"
name = "beat"
title = "Counts every 10 ms"
[signal.N]
expression = "floor(t * 100 + 0.5) % 200"
[[message]]
name = "Beat"
sent_by = "device"
can_id = 0x100
period_s = 0.01
fields = [{ name = "N", type = "u8" }]
"#;

fn run(device: &str, property: &str) -> TrialRun {
    let plan = format!(
        "name = \"plan\"\ntitle = \"It acknowledges\"\nrig = \"uart\"\nsteps = [\n\
         {{ wait = {{ duration_s = 0.5 }} }},\n\
         {{ send = {{ message = \"Set\", set = {{ Sp = 1200 }} }} }},\n\
         {{ wait = {{ duration_s = 1 }} }}]\n\
         [[property]]\nname = \"acknowledges\"\nalways = \"{property}\"\n"
    );
    let folder = project::of([
        ("devices/drive.toml", device),
        ("rigs/uart.toml", RIG),
        ("plan.toml", plan.as_str()),
    ]);
    let trial = project::load(&folder, "plan.toml");
    trial.unwrap_or_else(|error| panic!("{}", project::why(&error))).run().unwrap()
}

#[test]
fn a_wrong_first_answer_breaks_what_asks_for_a_right_one() {
    let asks = |rpm: u16| {
        format!("rises(desk.Sp > 1000 rpm) -> within 300 ms: drive.Setpoint == {rpm} rpm")
    };
    // Whether or not the drive had said something else before.
    for device in [DRIVE.to_owned(), format!("{DRIVE}{STATUS}")] {
        let right = run(&device, &asks(1_201));
        let right = right.property("acknowledges").unwrap();
        assert_eq!((right.held, right.never_asked.as_deref()), (Some(true), None));
        let wrong = run(&device, &asks(1_200));
        let wrong = wrong.property("acknowledges").unwrap();
        assert_eq!(wrong.held, Some(false), "{wrong:?}");
        let told = wrong.what.as_deref().unwrap_or_default();
        assert!(told.contains("not answered at 0.5") && told.contains("drive.Setpoint"), "{told}");
    }
}

/// A message that must never be sent, and one that is due although nothing was heard of its node.
#[test]
fn messages_are_judged_by_whether_they_are_sent() {
    for (property, held) in [
        ("not sent(drive.Ack)", false),
        ("not sent(drive.Status)", true),
        ("sent(desk.Set) -> within 300 ms: sent(drive.Ack)", true),
        ("sent(desk.Set) -> within 300 ms: sent(drive.Status)", false),
    ] {
        // Nobody asks for the status.
        let status = STATUS.replace("period_s = 0.05", "answers = \"Ask\"");
        let ask = "[[message]]\nname = \"Ask\"\nsent_by = \"host\"\ntext = \"ASK\\n\"\n";
        let run = run(&format!("{DRIVE}{ask}{status}"), property);
        let judged = run.property("acknowledges").unwrap();
        assert_eq!(judged.held, Some(held), "{property}: {judged:?}");
    }
}

/// The answer is under way when the plan ends, and no node runs any more when it arrives.
#[test]
fn nothing_is_judged_after_the_end_of_the_plan() {
    let plan = "name = \"plan\"\ntitle = \"It is never silent\"\nrig = \"can\"\nsteps = [{ wait = { duration_s = 2 } }]\n\
         [[property]]\nname = \"never silent\"\nalways = \"not (historically [0 s, 0.5 s]: not changes(beat.N))\"\n\
         [[property]]\nname = \"answers\"\nalways = \"rises(beat.N == 150) -> within 0.6 s: beat.N == 10\"\n\
         [[fault]]\ntarget = \"beat\"\nwhat = { babble = { frames_per_s = 1 } }\nwhen = { at_s = 1.99 }\n";
    let rig = RIG
        .replace("serial = {}", "can = {}")
        .replace("\"uart\"", "\"can0\"")
        .replace("drive", "beat");
    let folder = project::of([
        ("devices/beat.toml", BEAT),
        ("rigs/can.toml", rig.as_str()),
        ("plan.toml", plan),
    ]);
    let trial = project::load(&folder, "plan.toml");
    let run = trial.unwrap_or_else(|error| panic!("{}", project::why(&error))).run().unwrap();
    assert!(run.passed(), "{run}");
    assert_eq!(run.summary().simulated_s, 2.0);
    let silent = run.property("never silent").unwrap();
    assert_eq!(silent.held, Some(true), "{run}");
}
