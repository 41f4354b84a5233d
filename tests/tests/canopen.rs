//! CANopen with an independent stack: the Python package canopen is the master of the rotary table of `examples/`, in
//! virtual time. What it does and checks is in `interop/canopen_master.py`.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use harness::run::Prepared;
use plan::made::Made;
use std::process::Command;
use tempfile::TempDir;
use tests::project;

const PLAN: &str = r#"
name = "master"
title = "A master of somebody else finds nothing wrong"
rig = "bus"
steps = [
    { wait_until = { above = { quantity = "master.target_position", limit = 12.4 } }, time_limit_s = 60 },
    { wait = { duration_s = 1 }, label = "done" },
]
[[measurement]]
name = "said"
doc = "What the master says when it has checked everything"
quantity = "master.target_position"
where = { "during.done" = 1 }
unit = "deg"
check = { all_within = [12.5, 12.5] }
observations_min = 9
[[property]]
name = "it was stopped"
sometimes = "drive.nmt_state == \"stopped\""
"#;

const EDS: &str = include_str!("../../examples/rotary-table/devices/drive.eds");
const DRIVE: &str = include_str!("../../examples/rotary-table/devices/drive.toml");

fn folder(master: &str, plan: &str) -> TempDir {
    let rig = format!(
        "title = \"A rotary table and its master\"\n[[line]]\nname = \"can0\"\ncan = {{}}\n\
         [[node]]\nname = \"drive\"\nat = \"can0\"\nemulate = \"drive\"\n\
         [[node]]\nname = \"master\"\nat = \"can0\"\n{master}\n"
    );
    project::of([
        ("rigs/bus.toml", rig.as_str()),
        ("devices/drive.eds", EDS),
        ("devices/drive.toml", DRIVE),
        ("plan.toml", plan),
    ])
}

/// Returns a Python with canopen, if there is one.
fn python() -> Option<String> {
    let python = std::env::var("HIL_TESTS_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let loaded = Command::new(&python).args(["-c", "import can, canopen"]).output();
    if loaded.is_ok_and(|loaded| loaded.status.success()) {
        return Some(python);
    }
    let why = format!("{python} has no canopen");
    let how = "tests/interop/README.md says how to install it";
    skips::skip_unless("HIL_TESTS_NEED_PYTHON", why, how);
    None
}

#[test]
fn a_master_of_somebody_else_finds_nothing_wrong() {
    let Some(python) = python() else { return };
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/interop/canopen_master.py");
    let eds = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/rotary-table/devices/drive.eds");
    let command = format!(
        "under_test = {{ command = [\"{python}\", \"{script}\", \"{{can0}}\", \"{eds}\"] }}"
    );
    let folder = folder(&command, PLAN);
    let run = project::load(&folder, "plan.toml").unwrap().run().unwrap();
    assert!(run.passed(), "{run}");
}

/// A plan of the example's drive alone, and its outcome with the reason.
fn outcome(steps: &str, rest: &str) -> String {
    let plan = format!(
        "name = \"one\"\ntitle = \"One\"\ndevice = \"drive\"\nsteps = [\n{steps}\n]\n\
         [[measurement]]\nname = \"beats\"\ndoc = \"Heartbeats\"\nquantity = \"signal.nmt_state\"\nunit = \"1\"\n\
         check = {{ all_within = [0, 127] }}\n{rest}"
    );
    let folder = project::of([
        ("devices/drive.eds", EDS),
        ("devices/drive.toml", DRIVE),
        ("plan.toml", plan.as_str()),
    ]);
    match project::load(&folder, "plan.toml") {
        Ok(trial) => trial.run().unwrap().to_string(),
        Err(error) => {
            let source = std::error::Error::source(&error);
            source.map_or(error.to_string(), ToString::to_string)
        }
    }
}

const BOOT: &str = "{ wait = { duration_s = 0.15 } },";

#[test]
fn the_example_runs_green() {
    let plan = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/rotary-table/turns.toml");
    let run = harness::Trial::load(plan).unwrap().run().unwrap();
    assert!(run.passed(), "{run}");
}

#[test]
fn an_abort_ends_the_run_with_its_code_in_words() {
    let too_high = outcome(&format!("{BOOT} {{ sdo = {{ index = 0x6060, write = 7 }} }}"), "");
    assert!(
        too_high
            .contains("the device aborts with 0609 0031h (value of parameter written too high)"),
        "{too_high}"
    );
    let other = "{ sdo = { index = 0x1018, sub = 7, abort = 0x06020000 } }";
    let other = outcome(&format!("{BOOT} {other}"), "");
    let words = "aborts with 0609 0011h (sub-index does not exist), expected 0602 0000h";
    assert!(other.contains(words), "{other}");
    let none = outcome(&format!("{BOOT} {{ sdo = {{ index = 0x1000, abort = 0x06020000 }} }}"), "");
    assert!(none.contains("the device does it, expected an abort with 0602 0000h"), "{none}");
    let stopped =
        "{ send = { message = \"NMT\", set = { command = 2 } } }, { sdo = { index = 0x1000 } }";
    let stopped = outcome(&format!("{BOOT} {stopped}"), "");
    assert!(stopped.contains("the device does not answer"), "{stopped}");
}

#[test]
fn a_wrong_answer_is_told_from_an_abort_and_from_silence() {
    for (signal, value, said) in [
        ("command", 0x60, "the answer makes no sense: 0504 0001h (client/server command"),
        ("command", 0x4F, "the answer has 1 byte, expected 4"),
        // Without a length, the answer has what the object has.
        ("command", 0x42, "passed"),
        ("index", 0x6041, "the device does not answer; an answer for 6041sub0 came"),
    ] {
        let fault = format!(
            "[[fault]]\ntarget = \"device.SDO_response.{signal}\"\n\
             what = {{ signal_value = {{ value = {value} }} }}\nwhen = {{ at_s = 0 }}\n"
        );
        let read = format!("{BOOT} {{ sdo = {{ index = 0x1000, read = \"kind\" }} }}");
        let told = outcome(&read, &fault);
        assert!(told.contains(said), "{told}");
    }
}

#[test]
fn what_an_sdo_step_names_has_to_be_there() {
    let wrong = [
        ("{ sdo = { index = 0x6099, write = 1 } }", "6099sub0: 0602 0000h (object does not exist"),
        ("{ sdo = { index = 0x1008, read = \"name\" } }", "is not a number"),
        ("{ sdo = { index = 0x6060, write = 1000 } }", "`modes_of_operation` cannot be 1000"),
        ("{ sdo = { index = 0x6060, write = 1.5 } }", "= 1.5, and 2 would be written"),
        ("{ sdo = { node = \"other\", index = 0x6060 } }", "no EDS says which objects `other` has"),
        ("{ sdo = { index = 0x6060, write = 1, read = \"x\" } }", "`read` beside `write`"),
        (
            "{ sdo = { index = 0x607A, read = \"x\" } }, { sdo = { index = 0x6060, read = \"x\" } }",
            "`x` is in deg in another step",
        ),
    ];
    for (step, message) in wrong {
        let found = outcome(step, "");
        assert!(found.contains(message), "{step}: {found}");
    }
    let rest = "[[measurement]]\nname = \"x\"\ndoc = \"X\"\nquantity = \"sdo.x\"\nunit = \"1\"\ncheck = { all_within = [0, 1] }\n";
    let found = outcome(BOOT, rest);
    assert!(found.contains("no step `sdo` in this plan reads `x`"), "{found}");
}

#[test]
fn a_fault_strikes_a_pdo_and_an_object_in_it() {
    let steps =
        "{ send = { message = \"NMT\", set = { command = 1 } } }, { wait = { duration_s = 1 } }";
    let measure = |quantity: &str, check: &str| {
        format!(
            "[[measurement]]\nname = \"struck\"\ndoc = \"Struck\"\nquantity = \"{quantity}\"\nunit = \"1\"\ncheck = {check}\n"
        )
    };
    let fault = |target: &str, what: &str| {
        format!("[[fault]]\ntarget = \"{target}\"\nwhat = {what}\nwhen = {{ at_s = 0 }}\n")
    };
    let mode = measure("signal.modes_of_operation_display", "{ all_within = [1, 1] }");
    let steps = format!("{BOOT} {steps}");
    let clean = outcome(&steps, &mode);
    assert!(!clean.contains("failed"), "{clean}");
    let stuck = fault("device.modes_of_operation_display", "{ signal_value = { value = 3 } }");
    let struck = outcome(&steps, &format!("{mode}{stuck}"));
    assert!(struck.contains("failed"), "{struck}");
    let dropped = fault("device.TPDO1", "{ drop = { loss_percent = 100 } }");
    let struck = outcome(&steps, &format!("{mode}{dropped}"));
    assert!(struck.contains("failed"), "{struck}");
}

/// Two drives on one bus: messages that each hears by an identifier of its own are called by the node.
#[test]
fn a_tester_is_the_master_of_several() {
    let rig = "title = \"Two drives\"\n[[line]]\nname = \"can0\"\ncan = {}\n\
        [[node]]\nname = \"drive\"\nat = \"can0\"\nemulate = \"drive\"\n\
        [[node]]\nname = \"second\"\nat = \"can0\"\nemulate = \"second\"\n\
        [[node]]\nname = \"master\"\nat = \"can0\"\ntester = true\n";
    let plan = r#"
name = "two"
title = "Two"
rig = "two"
steps = [
    { wait = { duration_s = 0.15 } },
    { send = { message = "NMT", set = { command = 1 } } },
    { sdo = { node = "second", index = 0x607A, write = 30 } },
    { sdo = { node = "drive", index = 0x607A, read = "first" } },
    { sdo = { node = "second", index = 0x607A, read = "second" } },
    { send = { message = "second.RPDO1", set = { controlword = 6 } } },
    { wait = { duration_s = 0.15 }, label = "then" },
]
[[measurement]]
name = "first"
doc = "Of the first"
quantity = "sdo.first"
unit = "deg"
check = { all_within = [0, 0] }
[[measurement]]
name = "second"
doc = "Of the second"
quantity = "sdo.second"
unit = "deg"
check = { all_within = [30, 30] }
[[property]]
name = "only one"
always = "drive.statusword < 700 and (second.statusword == 561 or second.statusword == 592)"
[[property]]
name = "but one"
sometimes = "second.statusword == 561"
"#;
    let second = DRIVE
        .replace("name = \"drive\"", "name = \"second\"")
        .replace("node_id = 5", "node_id = 6");
    let folder = project::of([
        ("rigs/two.toml", rig),
        ("devices/drive.eds", EDS),
        ("devices/drive.toml", DRIVE),
        ("devices/second.toml", second.as_str()),
        ("plan.toml", plan),
    ]);
    let run = project::load(&folder, "plan.toml").unwrap().run().unwrap();
    assert!(run.passed(), "{run}");
    // Who reads the record sees the unit of what was read.
    let path = folder.path().join("plan.toml");
    let prepared = Prepared::load(path.to_str().unwrap(), &Made::default()).unwrap();
    for quantity in prepared.header(1).quantities {
        assert_eq!((quantity.unit.as_str(), quantity.title.is_empty()), ("deg", false));
    }
}
