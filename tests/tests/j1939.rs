//! J1939 with an independent stack: the Python package can-j1939 receives multi-packet broadcasts of an emulated node,
//! and sends it a multi-packet message, in virtual time.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use harness::TrialRun;
use std::process::Command;
use tempfile::TempDir;
use tests::project;

const DBC: &str = r#"
BU_: Engine Display
BO_ 2566834942 Dm1: 20 Engine
 SG_ Lamp : 0|8@1+ (1,0) [0|255] "" Display
 SG_ Last : 152|8@1+ (1,0) [0|250] "" Display
BO_ 2565799976 Answer: 20 Display
 SG_ Key : 152|8@1+ (1,0) [0|255] "" Engine
BO_ 2566849022 Echo: 8 Engine
 SG_ Heard : 0|8@1+ (1,0) [0|255] "" Display
BA_DEF_ BO_ "VFrameFormat" ENUM "StandardCAN","ExtendedCAN","reserved","J1939PG";
BA_DEF_ BU_ "NmStationAddress" INT 0 255;
BA_DEF_DEF_ "VFrameFormat" "J1939PG";
BA_DEF_DEF_ "NmStationAddress" 254;
BA_ "NmStationAddress" BU_ Engine 0;
BA_ "NmStationAddress" BU_ Display 40;
"#;

/// Counts the seconds, and sends the answer that it received.
const ENGINE: &str = r#"
name = "engine"
title = "An engine"
dbc = "engine.dbc"
node = "Engine"
[state.seconds]
rate = "1"
[signal.Lamp]
expression = "4"
[signal.Last]
expression = "min(floor(seconds), 250)"
[signal.Heard]
expression = "Key"
[message.Dm1]
period_s = 1
[message.Echo]
period_s = 0.1
[message.Answer]
"#;

const PLAN: &str = r#"
name = "codes"
title = "The display tells the engine its own fault codes"
rig = "vehicle"
steps = [
    { wait_until = { above = { quantity = "engine.Heard", limit = 2.5 } }, time_limit_s = 30 },
    { wait = { duration_s = 6 }, label = "both" },
]
[[measurement]]
name = "tells"
doc = "The display has them from the engine"
quantity = "display.Key"
where = { "during.both" = 1 }
unit = "1"
check = { all_within = [3, 12] }
observations_min = 5
[[measurement]]
name = "hears"
doc = "The engine has them from the display"
quantity = "engine.Heard"
where = { "during.both" = 1 }
unit = "1"
check = { all_within = [3, 12] }
observations_min = 50
[[measurement]]
name = "period"
doc = "What is told to everybody comes each second, in parts"
quantity = "period.engine.Dm1"
unit = "s"
check = { all_within = [0.99, 1.01] }
observations_min = 5
[[property]]
name = "answers within a second"
always = "rises(engine.Last > 4.5) -> within 1 s: engine.Heard > 4.5"
"#;

/// Returns a Python with can-j1939, if there is one.
fn python() -> Option<String> {
    let python = std::env::var("HIL_TESTS_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let loaded = Command::new(&python).args(["-c", "import can, j1939"]).output();
    if loaded.is_ok_and(|loaded| loaded.status.success()) {
        return Some(python);
    }
    let why = format!("{python} has no can-j1939");
    let how = "tests/interop/README.md says how to install it";
    skips::skip_unless("HIL_TESTS_NEED_PYTHON", why, how);
    None
}

fn folder(display: &str, plan: &str) -> TempDir {
    let rig = format!(
        r#"
title = "An engine and a display"
[[line]]
name = "can0"
can = {{ bit_rate = 250_000, dbc = "../devices/engine.dbc" }}
[[node]]
name = "engine"
at = "can0"
emulate = "engine"
[[node]]
name = "display"
at = "can0"
{display}
"#
    );
    project::of([
        ("rigs/vehicle.toml", rig.as_str()),
        ("devices/engine.dbc", DBC),
        ("devices/engine.toml", ENGINE),
        ("codes.toml", plan),
    ])
}

fn run(display: &str, plan: &str) -> TrialRun {
    project::load(&folder(display, plan), "codes.toml").unwrap().run().unwrap()
}

#[test]
fn a_stack_of_somebody_else_hears_and_is_heard() {
    let Some(python) = python() else { return };
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/interop/j1939_display.py");
    let command =
        format!("under_test = {{ command = [\"{python}\", \"{script}\", \"{{can0}}\"] }}");
    let run = run(&command, PLAN);
    assert!(run.passed(), "{run}");
}

/// The same with the plan as the display.
#[test]
fn a_tester_sends_in_parts() {
    let steps = PLAN.find("steps").unwrap()..PLAN.find("[[measurement]]").unwrap();
    let sends = "steps = [{ send = { message = \"Answer\", set = { Key = 7 }, every_s = 0.5 } }, \
                 { wait = { duration_s = 1 } }, { wait = { duration_s = 6 }, label = \"both\" }]\n";
    let plan = PLAN.replace(&PLAN[steps], sends);
    let (before, property) = plan.split_at(plan.find("[[property]]").unwrap());
    assert!(!property.is_empty());
    let run = run("tester = true", before);
    assert!(run.passed(), "{run}");
}

#[test]
fn no_fault_strikes_a_message_in_parts_alone() {
    let fault = "[[fault]]\ntarget = \"engine.Dm1\"\nwhat = { drop = { loss_percent = 50 } }\nwhen = { at_s = 1 }\n";
    let folder = folder("tester = true", &format!("{PLAN}{fault}"));
    let error = project::load(&folder, "codes.toml").unwrap_err();
    let error = std::error::Error::source(&error).map_or(error.to_string(), ToString::to_string);
    assert!(error.contains("`Dm1` goes in parts: no fault strikes it alone"), "{error}");
}

/// Runs an emulated engine, address 0, on the frames of a log; the DBC has a command to this destination.
fn told(destination: u32, steps: &str) -> TrialRun {
    let id = 0x8000_0000_u32 | 0x18EF_0028 | destination << 8;
    let dbc = format!(
        "BU_: Engine Display\nBO_ {id} Command: 8 Display\n SG_ Go : 0|8@1+ (1,0) [0|255] \"\" Engine\n\
         BO_ 2566849022 State: 8 Engine\n SG_ Going : 0|8@1+ (1,0) [0|255] \"\" Display\n{}",
        &DBC[DBC.find("BA_DEF_").unwrap()..]
    );
    let engine = "name = \"engine\"\ntitle = \"An engine\"\ndbc = \"engine.dbc\"\nnode = \"Engine\"\n\
        [signal.Going]\nexpression = \"Go\"\n[message.State]\nperiod_s = 0.1\n[message.Command]\n";
    let rig = "[[line]]\nname = \"can0\"\ncan = { bit_rate = 250_000, dbc = \"../devices/engine.dbc\" }\n\
        [[node]]\nname = \"engine\"\nat = \"can0\"\nemulate = \"engine\"\n\
        [[node]]\nname = \"display\"\nat = \"can0\"\nreplay = { log = \"display.log\" }\n";
    let plan = "name = \"told\"\ntitle = \"\"\nrig = \"vehicle\"\nsteps = [{ wait = { duration_s = 3 } }]\n\
        [[property]]\nname = \"goes\"\nsometimes = \"engine.Going == 7\"\n";
    let folder = project::of([
        ("rigs/vehicle.toml", rig),
        ("rigs/display.log", steps),
        ("devices/engine.dbc", dbc.as_str()),
        ("devices/engine.toml", engine),
        ("told.toml", plan),
    ]);
    project::load(&folder, "told.toml").unwrap().run().unwrap()
}

/// Found by a user: an engine with the address 0 obeyed a command to node 5, and not one to all.
#[test]
fn a_command_is_obeyed_by_the_node_that_it_is_for() {
    for (destination, to, goes) in [
        (0, "00", true),
        (0, "FF", true),
        (0xFF, "00", true),
        (0xFF, "FF", true),
        (0xFF, "05", false),
    ] {
        let log = format!("(0.000000) can0 18EF{to}28#07FFFFFFFFFFFFFF\n");
        let run = told(destination, &log);
        assert_eq!(run.passed(), goes, "{destination:02X} {to}: {run}");
    }
}

/// Found by a user: packets that came after the receiver had given up were used all the same.
#[test]
fn a_transfer_that_the_receiver_aborted_is_not_used() {
    let begin = "can0 1CEC0028#100A00020200EF00";
    let (one, two) = ("can0 1CEB0028#0107000000000000", "can0 1CEB0028#0200000000000000");
    for (first, goes) in [(0.05, true), (1.6, false)] {
        let log = format!("(0.000000) {begin}\n({first:.6}) {one}\n({:.6}) {two}\n", first + 0.01);
        let run = told(0, &log);
        assert_eq!(run.passed(), goes, "{first}: {run}");
    }
}
