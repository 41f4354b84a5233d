//! Faults of one message, its counter, its checksum or one of its signals, and formulas that judge counters and
//! checksums.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use harness::{Trial, TrialError};
use record::RecordKind;
use record::run_folder::RunFolder;
use tempfile::TempDir;
use tests::project;

const DBC: &str = r#"VERSION ""
BU_: Manager Cells
BO_ 256 CellStatus: 8 Cells
 SG_ Crc : 0|8@1+ (1,0) [0|255] "" Manager
 SG_ Alive : 8|4@1+ (1,0) [0|15] "" Manager
 SG_ Limit : 16|16@1+ (0.01,0) [0|300] "A" Manager
BO_ 257 CellInfo: 2 Cells
 SG_ Number : 0|16@1+ (1,0) [0|1000] "" Manager
BO_ 512 Request: 5 Manager
 SG_ Crc : 0|8@1+ (1,0) [0|255] "" Cells
 SG_ Alive : 8|4@1+ (1,0) [0|15] "" Cells
 SG_ Limit : 16|16@1+ (0.01,0) [0|300] "A" Cells
"#;

/// Sends back the limit that it received in accepted messages.
const CELLS: &str = r#"
name = "cells"
title = "Cells"
dbc = "pack.dbc"
node = "Cells"
[message.CellStatus]
period_s = 0.1
e2e = { profile = "1C", data_id = 0x123, counter = "Alive", checksum = "Crc" }
[message.CellInfo]
period_s = 0.1
[message.Request]
e2e = { profile = "1A", data_id = 0x0a5b, counter = "Alive", checksum = "Crc" }
[signal."CellStatus.Limit"]
expression = "Request.Limit"
"#;

pub const RIG: &str = r#"title = "Cells and the plan"
[[line]]
name = "can0"
can = { bit_rate = 250_000, dbc = "pack.dbc" }
message.Request = { e2e = { profile = "1A", data_id = 0x0a5b, counter = "Alive", checksum = "Crc" } }
[[node]]
name = "cells"
at = "can0"
emulate = "cells"
[[node]]
name = "manager"
at = "can0"
tester = true
"#;

/// The limit is 9 A, and from 1 s on 20 A; a fault begins between the two, at 0.5 s.
const STEPS: &str = "\
    { send = { message = \"Request\", set = { Limit = 9 }, every_s = 0.05 } }, { wait = { duration_s = 1 } }, \
    { send = { message = \"Request\", set = { Limit = 20 }, every_s = 0.05 } }, { wait = { duration_s = 0.5 } }, \
    { wait = { duration_s = 2 }, label = \"after\" }";

const PROPERTIES: &str = r#"
[[property]]
name = "counted"
always = "cells.Alive follows"
[[property]]
name = "sealed"
always = "cells.CellStatus.Crc fits"
"#;

/// Loads the plan from a folder with this rig and plan.
pub fn load_pack(rig: &str, plan: &str) -> (TempDir, Result<Trial, TrialError>) {
    let folder = project::of([
        ("rigs/pack.toml", rig),
        ("rigs/pack.dbc", DBC),
        ("devices/pack.dbc", DBC),
        ("devices/cells.toml", CELLS),
        ("plan.toml", plan),
    ]);
    let trial = project::load(&folder, "plan.toml");
    (folder, trial)
}

fn load(fault: &str) -> (TempDir, Result<Trial, TrialError>) {
    let plan = format!(
        "name = \"plan\"\ntitle = \"\"\nrig = \"pack\"\nsteps = [{STEPS}]\n[[measurement]]\nname = \"limit\"\ndoc = \"\"\n\
         quantity = \"cells.CellStatus.Limit\"\nwhere = {{ \"during.after\" = 1 }}\nunit = \"A\"\n\
         check = {{ all_within = [0, 300] }}\n{PROPERTIES}{fault}"
    );
    load_pack(RIG, &plan)
}

fn fault(target: &str, what: &str) -> String {
    format!("[[fault]]\ntarget = \"{target}\"\nwhat = {{ {what} }}\nwhen = {{ at_s = 0.5 }}\n")
}

/// The final maximum of the limit that the cells sent, and whether their counter and their checksum were always right.
fn run(fault: &str) -> (Option<f64>, bool, bool) {
    let (_folder, trial) = load(fault);
    let run = trial.unwrap_or_else(|error| panic!("{error:?}")).run().unwrap();
    let held = |name: &str| run.property(name).unwrap().held.unwrap();
    (run.value("limit"), held("counted"), held("sealed"))
}

#[test]
fn without_a_fault_everything_is_right() {
    assert_eq!(run(""), (Some(20.0), true, true));
}

/// The receiver checks counter and checksum: a struck message is rejected, or used as it is.
#[test]
fn what_is_sent_to_a_node_is_struck_in_one_place() {
    for (target, what, told) in [
        ("manager.Request", "stuck_counter = { for_s = 60 }", 9.0),
        ("manager.Request", "wrong_checksum = { wrong_percent = 100 }", 9.0),
        ("manager.Request", "counter_jump = { ahead = 2 }", 20.0),
        ("manager.Request", "frozen_message = { for_s = 60 }", 9.0),
        ("manager.Request", "drop = { loss_percent = 100 }", 9.0),
        ("manager.Limit", "stuck_signal = { for_s = 60 }", 9.0),
        ("manager.Limit", "signal_value = { value = 55 }", 55.0),
        ("manager.Request.Limit", "signal_offset = { range_percent = 10 }", 50.0),
        // The bits can represent more than the range.
        ("manager.Limit", "signal_value = { value = 1e6 }", 655.35),
    ] {
        let (limit, counted, sealed) = run(&fault(target, what));
        let limit = limit.unwrap();
        // The cells do not send values beyond their range.
        let told = f64::min(told, 300.0);
        assert!((limit - told).abs() < 1e-9, "{target} {what}: {limit}, and not {told}");
        assert!(counted && sealed, "{target} {what}: what the cells send was struck too");
    }
}

/// Notes of a run with this fault at its end, without the counts.
fn told(fault: &str) -> Vec<String> {
    let (_folder, trial) = load(fault);
    let run = trial.unwrap_or_else(|error| panic!("{error:?}")).run().unwrap();
    let records = RunFolder::open(run.folder()).unwrap().records().unwrap();
    let note = |kind| match kind {
        RecordKind::Note(text) => text.split_once(" times ").map(|(_, what)| what.to_owned()),
        _ => None,
    };
    records.filter_map(|record| note(record.unwrap().kind)).collect()
}

#[test]
fn what_is_out_of_its_range_or_not_used_is_told() {
    assert_eq!(told(""), [""; 0]);
    for (target, what, expected) in [
        (
            "manager.Limit",
            "signal_value = { value = 1e6 }",
            &[
                "manager.Request.Limit was out of its range, 0 to 300 A",
                "cells.CellStatus.Limit was clipped to its range, 0 to 300 A; the farthest value was 655.4 A",
            ][..],
        ),
        (
            "cells.Limit",
            "signal_value = { value = 400 }",
            &["cells.CellStatus.Limit was out of its range, 0 to 300 A"],
        ),
        (
            "manager.Request",
            "wrong_checksum = { wrong_percent = 100 }",
            &[
                "manager.Request had a wrong checksum, and its values did not count",
                "cells did not use a message with a wrong counter or checksum",
            ],
        ),
    ] {
        assert_eq!(told(&fault(target, what)), expected, "{target} {what}");
    }
}

#[test]
fn what_a_node_sends_is_judged_by_its_counter_and_its_checksum() {
    for (target, what, expected) in [
        ("cells.CellStatus", "stuck_counter = { for_s = 60 }", (Some(20.0), false, true)),
        ("cells.CellStatus", "counter_jump = { ahead = 3 }", (Some(20.0), false, true)),
        ("cells.CellStatus", "wrong_checksum = { wrong_percent = 50 }", (Some(20.0), true, false)),
        ("cells.CellStatus", "frozen_message = { for_s = 60 }", (Some(9.0), false, true)),
        ("cells.CellStatus", "drop = { loss_percent = 30 }", (Some(20.0), false, true)),
        ("cells.CellStatus", "duplicate = { duplicate_percent = 30 }", (Some(20.0), false, true)),
        // The checksum as a signal: it stays as the fault makes it, and no value counts.
        ("cells.CellStatus.Crc", "signal_offset = { range_percent = 1 }", (None, true, false)),
        ("cells.Crc", "stuck_signal = { for_s = 60 }", (None, true, false)),
        // Other messages of the same node are not affected.
        ("cells.CellInfo", "drop = { loss_percent = 30 }", (Some(20.0), true, true)),
        ("cells.CellInfo", "frozen_message = { for_s = 60 }", (Some(20.0), true, true)),
        ("cells", "drop = { loss_percent = 30 }", (Some(20.0), false, true)),
    ] {
        assert_eq!(run(&fault(target, what)), expected, "{target} {what}");
    }
}

#[test]
fn a_fault_that_never_began_is_told() {
    let late = fault("cells.CellStatus", "drop = { loss_percent = 100 }");
    let (_folder, trial) = load(&late.replace("at_s = 0.5", "at_s = 20"));
    let run = trial.unwrap_or_else(|error| panic!("{error:?}")).run().unwrap();
    assert_eq!(run.summary().notes, ["fault 0 never began: drop of cells.CellStatus"]);
}

#[test]
fn what_should_have_been_said_and_never_was_breaks_its_property() {
    let property = |name: &str, limit: u8| {
        let rises = format!("rises(cells.CellStatus.Limit > {limit} A)");
        let always = format!("{rises} -> within 100 ms: cells.Number == 7");
        format!("[[property]]\nname = \"{name}\"\nalways = \"{always}\"\n")
    };
    let mute = fault("cells.CellInfo", "drop = { loss_percent = 100 }").replace("0.5", "0");
    let properties = format!("{}{}", property("asked", 15), property("unasked", 200));
    // Never, and for the first time when the answer had been due for long.
    for (mute, expected) in [
        (mute.clone(), "not judged at 1.101 s: no value of cells.Number"),
        (
            mute + "duration_s = 2\n",
            "not answered at 1.101 s: no value of cells.Number until 1.201 s",
        ),
    ] {
        let (_folder, trial) = load(&format!("{properties}{mute}"));
        let run = trial.unwrap_or_else(|error| panic!("{error:?}")).run().unwrap();
        let asked = run.property("asked").unwrap();
        assert_eq!((asked.held, asked.what.as_deref()), (Some(false), Some(expected)));
        let unasked = run.property("unasked").unwrap();
        assert_eq!(unasked.held, Some(true));
        assert_eq!(unasked.never_asked.as_deref(), Some("rises(cells.CellStatus.Limit > 200 A)"));
    }
}

#[test]
fn a_formula_that_looks_beyond_the_end_was_never_judged() {
    let long = "[[property]]\nname = \"long\"\nalways = \"for 10 s: cells.Limit < 300 A\"\n";
    let (_folder, trial) = load(long);
    let run = trial.unwrap_or_else(|error| panic!("{error:?}")).run().unwrap();
    let long = run.property("long").unwrap();
    let told = "never judged: the run ended at 3.5 s, and the formula looks 10 s ahead";
    assert_eq!((long.held, long.what.as_deref()), (Some(false), Some(told)));
}

/// Otherwise a formula would judge the node by another checksum than that which it sends.
#[test]
fn a_device_file_and_its_line_must_agree() {
    let other =
        "message.CellStatus = { checksum = { signal = \"Crc\", crc = \"crc8-autosar\" } }\n";
    let alike = "message.CellStatus = { e2e = { profile = \"1C\", data_id = 0x123, counter = \"Alive\", checksum = \"Crc\" } }\n";
    let plan =
        "name = \"plan\"\ntitle = \"\"\nrig = \"pack\"\nsteps = [{ wait = { duration_s = 1 } }]\n"
            .to_owned()
            + PROPERTIES;
    let rig = |more: &str| RIG.replace("message.Request", &format!("{more}message.Request"));
    assert!(load_pack(&rig(alike), &plan).1.is_ok());
    let Err(refused) = load_pack(&rig(other), &plan).1 else { panic!("taken") };
    let told = project::why(&refused);
    let expected = "the file of `cells` and line `can0` state different checksums of `CellStatus`";
    assert!(told.contains(expected), "{told}");
}

#[test]
fn what_cannot_be_struck_is_shown_in_its_place() {
    let both = |target: &str, what: &str| fault(target, what);
    let cases = [
        both("cells.CellStatsu", "frozen_message = { for_s = 1 }"),
        both("manager.Limit", "frozen_message = { for_s = 1 }"),
        both("cells.CellStatus", "stuck_signal = { for_s = 1 }"),
        both("cells.CellInfo", "wrong_checksum = { wrong_percent = 1 }"),
        both("cells.CellInfo", "stuck_counter = { for_s = 1 }"),
        both("cells.Limit", "drop = { loss_percent = 1 }"),
        both("cells", "stuck_signal = { for_s = 1 }"),
        both("cells.CellStatus", "babble = { frames_per_s = 10 }"),
        both("cells.CellStatus", "drop = { loss_percent = 1 }") + "toward = \"host\"\n",
        both("can0", "drop = { loss_percent = 1 }") + "toward = \"host\"\n",
        "[[property]]\nalways = \"cells.Limit follows\"\n".to_owned(),
        "[[property]]\nalways = \"cells.Alive fits\"\n".to_owned(),
        "[[property]]\nalways = \"cells.Alvie follows\"\n".to_owned(),
    ];
    let told = cases.map(|case| {
        let (folder, trial) = load(&case);
        let Err(error) = trial else { panic!("taken: {case}") };
        let mut said = vec![error.to_string()];
        let mut cause = std::error::Error::source(&error);
        while let Some(one) = cause {
            said.push(one.to_string());
            cause = one.source();
        }
        let whole = format!("{error:?}");
        let help = whole.lines().filter(|line| line.contains("help")).collect::<Vec<_>>().join("");
        format!("{case}{}\n{help}\n", said.join(": ")).replace(folder.path().to_str().unwrap(), "")
    });
    insta::assert_snapshot!(told.join("\n"));
}

/// Found by a user: a bit that was flipped past the CRC of the bus broke a property of a sound node, and hid the fault of
/// another.
#[test]
fn a_damaged_message_says_nothing_of_its_values() {
    let property =
        "\n[[property]]\nname = \"limit\"\nalways = \"cells.CellStatus.Limit <= 20 A\"\n";
    let corrupt = fault("cells", "corrupt = { corrupt_percent = 100 }");
    let (_folder, trial) = load(&format!("{property}{corrupt}"));
    let run = trial.unwrap_or_else(|error| panic!("{error:?}")).run().unwrap();
    assert_eq!(run.property("limit").unwrap().held, Some(true), "{:?}", run.summary().reason);
    assert_eq!(run.property("sealed").unwrap().held, Some(false));
    assert_eq!(run.value("limit"), None, "no whole message came during the step");
}
