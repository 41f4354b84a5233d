//! A program under test in virtual time: a user's program in Python that does not know the harness.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use harness::{Trial, TrialRun};
use record::sink::Level;
use std::path::Path;
use tempfile::TempDir;
use tests::project;

const EXAMPLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/battery-pack");

/// Creates a copy of the example with this command as its manager.
fn pack(command: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for part in ["charge.toml", "silence.toml", "deadlines.toml", "rigs", "devices"] {
        let copied = copy(&Path::new(EXAMPLE).join(part), &folder.path().join(part));
        copied.unwrap_or_else(|error| panic!("{part}: {error}"));
    }
    let rig = folder.path().join("rigs/pack.toml");
    let text = std::fs::read_to_string(&rig).unwrap();
    let changed = text.replace(r#""python3", "manager.py", "{can0}""#, command);
    assert_ne!(text, changed);
    std::fs::write(rig, changed).unwrap();
    folder
}

fn copy(from: &Path, to: &Path) -> std::io::Result<()> {
    if !from.is_dir() {
        return std::fs::copy(from, to).map(|_| ());
    }
    std::fs::create_dir(to)?;
    for entry in from.read_dir()? {
        let entry = entry?;
        copy(&entry.path(), &to.join(entry.file_name()))?;
    }
    Ok(())
}

/// Returns the command of the manager, with one of its mistakes if given.
fn manager(mistake: Option<&str>) -> String {
    let words = format!(r#""python3", "{EXAMPLE}/manager.py", "{{can0}}""#);
    mistake.map_or_else(|| words.clone(), |mistake| format!(r#"{words}, "--mistake", "{mistake}""#))
}

fn load(folder: &TempDir, plan: &str) -> Trial {
    project::load(folder, plan).unwrap_or_else(|error| panic!("{error:?}"))
}

fn run(command: &str, plan: &str) -> TrialRun {
    load(&pack(command), plan).run().unwrap()
}

#[test]
fn a_sound_program_passes_and_each_mistake_is_found_by_what_is_about_it() {
    let sound = pack(&manager(None));
    for plan in ["charge.toml", "silence.toml", "deadlines.toml"] {
        let run = load(&sound, plan).run().unwrap();
        assert!(run.passed(), "{plan}: {run}");
    }
    for (mistake, plan, expected) in [
        ("no-derating", "deadlines.toml", "derates when it is warm"),
        ("opens-late", "deadlines.toml", "opens on over-voltage"),
        ("stuck-counter", "deadlines.toml", "counts"),
        ("skips-precharge", "deadlines.toml", "charges behind a precharge"),
        ("long-time-out", "silence.toml", "opens when the cells fall silent"),
    ] {
        let run = run(&manager(Some(mistake)), plan);
        let broken = run.summary().properties.iter().filter(|one| one.is_broken());
        let broken: Vec<&str> = broken.map(|one| one.name.as_str()).collect();
        assert_eq!(broken, [expected], "{mistake}: {run}");
    }
}

/// The same bytes at the same nanoseconds.
#[test]
fn a_seed_gives_the_same_record_again() {
    let folder = pack(&manager(None));
    let record = |name: &str| {
        let out = folder.path().join(name);
        let run = load(&folder, "charge.toml").in_folder(&out).run().unwrap();
        assert!(run.passed(), "{run}");
        std::fs::read(out.join("record.hilrec")).unwrap()
    };
    let first = record("first");
    assert!(first.len() > 1_000 && first == record("second"));
}

#[test]
fn a_campaign_shrinks_what_breaks_the_program() {
    let folder = pack(&manager(None));
    let findings = load(&folder, "charge.toml").campaign().faults(&["disconnect"]).cases(12).run();
    let findings = findings.unwrap();
    assert!(!findings.held(), "{findings}");
    // One fault remains, in a plan that can be run.
    for one in findings.smallest() {
        let text = std::fs::read_to_string(&one.path).unwrap();
        assert_eq!(text.matches("[[fault]]").count(), 1, "{text}");
    }
}

#[test]
fn a_command_that_names_no_line_is_refused_before_the_run() {
    for (command, expected) in [
        (r#""python3", "--port={can1}""#, "no line `can1` for `--port={can1}` of `manager`"),
        (r#""python3", "{can0""#, "a brace without its counterpart"),
    ] {
        let Err(error) = project::load(&pack(command), "charge.toml") else { panic!("taken") };
        let told = project::why(&error);
        assert!(told.contains(expected), "{told}");
    }
}

#[test]
fn what_does_not_start_ends_or_says_nothing_is_told() {
    for (command, outcome, reason) in [
        (r#""/no/such/program""#, "error", "failed to start `manager`"),
        (r#""python3", "-c", "import sys; print('no cells'); sys.exit(3)""#, "failed", "no cells"),
        (r#""python3", "-c", "import time; time.sleep(1e6)""#, "failed", "ContactorClosed"),
    ] {
        let run = run(command, "charge.toml");
        let summary = run.summary();
        assert_eq!(summary.outcome.name(), outcome, "{command}: {run}");
        let told = summary.reason.as_deref().unwrap_or_default();
        assert!(told.contains(reason), "{command}: {told}");
    }
}

const OVEN: &str = r#"
name = "oven"
title = "An oven that tells its temperature in lines of text"
[serial]
baud = 9600
[state.temperature]
start = 20
rate = "if(Heat, 10, -5)"
[[message]]
name = "Reading"
sent_by = "device"
text = "T={Temperature:.1}\n"
period_s = 0.1
[signal.Temperature]
expression = "temperature"
[[message]]
name = "Switch"
sent_by = "host"
text = "H={Heat:.0}\n"
"#;

/// Heats up to 50 degrees, and leaves the terminal's settings as they are.
const THERMOSTAT: &str = "\
import os, sys, tty
port = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)
tty.setraw(port)
text = b''
while True:
    text += os.read(port, 64)
    while b'\\n' in text:
        line, text = text.split(b'\\n', 1)
        os.write(port, b'H=%d\\n' % (float(line[2:]) < 50))
";

#[test]
fn a_program_on_a_serial_line_needs_no_port() {
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("thermostat.py");
    let rig = format!(
        "title = \"An oven and its thermostat\"\n[[line]]\nname = \"uart\"\nserial = {{}}\n\
         [[node]]\nname = \"oven\"\nat = \"uart\"\nemulate = \"oven\"\n\
         [[node]]\nname = \"thermostat\"\nat = \"uart\"\n\
         under_test = {{ command = [\"python3\", \"{}\", \"{{uart}}\"] }}\n",
        program.display()
    );
    let plan = "name = \"warms\"\ntitle = \"\"\nrig = \"oven\"\n\
        steps = [{ wait = { duration_s = 20 }, label = \"up\" }, { wait = { duration_s = 60 }, label = \"there\" }]\n\
        [[measurement]]\nname = \"held\"\ndoc = \"\"\nquantity = \"oven.Temperature\"\n\
        where = { \"during.there\" = 1 }\nunit = \"1\"\ncheck = { all_within = [47, 53] }\nobservations_min = 500\n";
    let files = [
        ("thermostat.py", THERMOSTAT),
        ("rigs/oven.toml", &rig),
        ("devices/oven.toml", OVEN),
        ("warms.toml", plan),
    ];
    project::write(folder.path(), files);
    let run = load(&folder, "warms.toml").run().unwrap();
    assert!(run.passed(), "{run}");
}

/// Ends with an error if it receives nothing.
const LISTENER: &str = "\
import socket, sys, time
bus = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
bus.bind((sys.argv[1],))
bus.settimeout(1)
for _ in range(20):
    bus.recv(16)
time.sleep(1e6)
";

/// The record contains what the cells sent; the correct program repeats its output, a changed one does not.
#[test]
fn a_recorded_run_is_given_once_more_to_a_program() {
    let recorded = load(&pack(&manager(None)), "deadlines.toml").with_record(Level::Full);
    let recorded = recorded.run().unwrap();
    let again = |mistake| {
        let trial = load(&pack(&manager(mistake)), "deadlines.toml");
        trial.rerun(recorded.folder()).unwrap()
    };
    let same = again(None);
    assert_eq!((same.difference, same.recorded.outputs > 20), (None, true));
    let changed = again(Some("skips-precharge")).difference.unwrap();
    assert!(changed.recorded.is_some() && changed.now.is_some(), "{changed:?}");
}

#[test]
fn a_program_listens_beside_the_papers_robot() {
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("listener.py");
    let node = |port: &str| {
        format!(
            "title = \"\"\ndevices = \"paper\"\n[[node]]\nname = \"listener\"\nat = \"base\"\n\
             under_test = {{ command = [\"python3\", \"{}\", \"{port}\"] }}\n",
            program.display()
        )
    };
    let plan = "name = \"heard\"\ntitle = \"\"\nrig = \"both\"\nsteps = [{ bias_test = { duration_s = 5 } }]\n\
        [[measurement]]\nname = \"bias\"\ndoc = \"\"\nquantity = \"bias.mean\"\nunit = \"deg/s\"\n\
        check = { all_within = [-1, 1] }\n";
    project::write(folder.path(), [("listener.py", LISTENER), ("heard.toml", plan)]);
    for (port, outcome) in [("{base}", "passed"), ("other", "failed")] {
        project::write(folder.path(), [("rigs/both.toml", node(port))]);
        let run = load(&folder, "heard.toml").run().unwrap();
        assert_eq!(run.summary().outcome.name(), outcome, "{port}: {run}");
    }
}
