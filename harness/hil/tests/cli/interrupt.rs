//! Ctrl-C, and the files that it leaves.
#![cfg(unix)]

use crate::hil::{ENDLESS, Hil, Ran, TURN};
use rustix::process::{Pid, Signal, kill_process};
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::Duration;

/// Longer than anything here takes on a slow machine.
const PATIENCE: Duration = Duration::from_secs(60);
const STEP: Duration = Duration::from_millis(20);

#[expect(clippy::disallowed_methods, reason = "waits for another process")]
pub fn wait_for(what: &str, mut done: impl FnMut() -> bool) {
    let mut waited = Duration::ZERO;
    while !done() {
        assert!(waited < PATIENCE, "waited in vain for {what}");
        std::thread::sleep(STEP);
        waited += STEP;
    }
}

pub fn signal(child: &Child, signal: Signal) {
    kill_process(Pid::from_child(child), signal).unwrap();
}

fn start(hil: &Hil, arguments: &[&str], record: &Path) -> Child {
    std::fs::write(hil.path("endless.toml"), ENDLESS).unwrap();
    let mut command = hil.command(arguments);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let length = || record.metadata().map_or(0, |about| about.len());
    wait_for("the record", || length() > 0);
    // The record is written in blocks: once the first one follows the header, the run is well under way.
    let header = length();
    wait_for("records", || length() > header);
    child
}

#[test]
fn the_first_ctrl_c_ends_the_run_in_good_order() {
    for stop in [Signal::INT, Signal::TERM] {
        let hil = Hil::with_plan(TURN);
        let arguments = ["run", "endless.toml", "turn.toml", "--out", "runs"];
        let record = hil.path("runs/endless-seed1/record.hilrec");
        let child = start(&hil, &arguments, &record);
        signal(&child, stop);
        let ran = Ran::of(child.wait_with_output().unwrap()).exits(5);
        assert!(ran.err.contains("stopping in order"), "{}", ran.err);
        assert!(ran.err.contains("not run: turn.toml"), "{}", ran.err);
        assert!(ran.out.contains("endless: aborted: stopped by request"), "{}", ran.out);
        assert_eq!(hil.outcome("runs/endless-seed1"), "aborted");
        assert!(!hil.path("runs/turn-seed1").exists(), "remaining plans are skipped");

        // The record is complete, and shows the stop command to the base at the end.
        let shown = hil.run(&["show", "runs/endless-seed1"]).exits(0);
        let stopped = shown.out.find("note stopped by request").expect(&shown.out);
        assert!(shown.out[stopped..].contains("stop"), "{}", &shown.out[stopped..]);
        // Judged again, the result is the same: its measurements passed, and it was stopped.
        let check = ["check", "runs/endless-seed1", "--plan", "endless.toml"];
        let checked = hil.run(&check).exits(5);
        assert!(checked.out.contains("1 passed"), "{}", checked.out);
    }
}

/// A device under test in real time, which ignores the request to end, would keep its ports.
#[test]
fn the_second_ctrl_c_ends_what_was_started_as_well() {
    let hil = Hil::with_plan(TURN);
    let rig = "[[line]]\nname = \"uart\"\nserial = {}\n\
        [[node]]\nname = \"stays\"\nat = \"uart\"\n\
        under_test = { command = [\"sh\", \"./stays.sh\", \"{uart}\"] }\n";
    std::fs::create_dir(hil.path("rigs")).unwrap();
    std::fs::write(hil.path("rigs/stays.toml"), rig).unwrap();
    let plan = "name = \"stays\"\ntitle = \"\"\nrig = \"stays\"\n\
        steps = [{ wait = { duration_s = 600 }, label = \"waits\" }]\n\
        [[measurement]]\nname = \"time\"\ndoc = \"Of the step\"\nquantity = \"step.duration\"\n\
        unit = \"s\"\ncheck = { all_within = { at_least = 1 } }\n";
    std::fs::write(hil.path("stays.toml"), plan).unwrap();
    let script = "trap '' TERM INT\necho $$ > pid\nwhile :; do sleep 0.1; done\n";
    std::fs::write(hil.path("stays.sh"), script).unwrap();
    let mut command = hil.command(&["run", "stays.toml", "--clock", "real"]);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let pid = || std::fs::read_to_string(hil.path("pid")).ok()?.trim().parse::<i32>().ok();
    wait_for("the program", || pid().is_some());
    // One that comes at once is the same request; a later one is another.
    wait_for("the end", || {
        let has_ended = child.try_wait().unwrap().is_some();
        if !has_ended {
            signal(&child, Signal::INT);
        }
        has_ended
    });
    assert_eq!(child.wait().unwrap().code(), Some(5));
    let program = format!("/proc/{}", pid().unwrap());
    wait_for("the end of the program", || !Path::new(&program).exists());
}

/// What was measured until then is no envelope.
#[test]
fn an_envelope_that_is_interrupted_has_no_result() {
    let hil = Hil::with_plan(TURN);
    let arguments = ["campaign", "turn.toml", "--envelope", "drop", "--out", "kept"];
    let mut command = hil.command(&arguments);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let journal = hil.path("kept/runs.jsonl");
    wait_for("runs", || {
        std::fs::read_to_string(&journal).is_ok_and(|text| text.lines().count() > 2)
    });
    signal(&child, Signal::INT);
    let ran = Ran::of(child.wait_with_output().unwrap()).exits(5);
    assert!(!ran.out.contains("tolerated"), "{}", ran.out);
    assert!(ran.err.contains("the same command goes on: kept"), "{}", ran.err);
    for name in ["envelopes.json", "report.html", "junit.xml"] {
        assert!(!hil.path("kept").join(name).exists(), "{name}");
    }
}

#[test]
fn seeds_stop_too() {
    let hil = Hil::new();
    std::fs::write(hil.path("endless.toml"), ENDLESS).unwrap();
    let mut command = hil.command(&["run", "endless.toml", "--seeds", "4"]);
    command.env("RUST_LOG", "info").stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    // The log shows when the signal handlers are installed.
    let mut err = std::io::BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    std::io::BufRead::read_line(&mut err, &mut line).unwrap();
    assert!(line.contains("4 seeds"), "{line}");
    signal(&child, Signal::INT);
    let ran = Ran::of(child.wait_with_output().unwrap()).exits(5);
    assert!(ran.out.contains("no seed ran"), "{}", ran.out);
}
