//! A user's program under test in virtual time, and programs that break the model: each has a named error and a status,
//! and leaves no process.

use super::hil::{Hil, Ran};
use super::interrupt::{signal, wait_for};
use rustix::process::Signal;
use std::fs;
use std::path::Path;
use std::process::Stdio;

const RIG: &str = r#"
title = "A program alone"
[[line]]
name = "can0"
can = { bit_rate = 500_000, dbc = "../beat.dbc" }
[[node]]
name = "beat"
at = "can0"
under_test = { command = ["python3", "./beat.py", "{can0}"] }
virtual_time = { wall_limit_s = 10, processes_max = 8 }
"#;

const DBC: &str = "VERSION \"\"\nBU_: Beat\nBO_ 291 Beat: 1 Beat\n SG_ Count : 0|8@1+ (1,0) [0|0] \"\" Vector__XXX\n";

pub const PLAN: &str = r#"
name = "beats"
title = "A program beats"
rig = "beat"
steps = [{ wait = { duration_s = 3 } }]

[[measurement]]
name = "count"
doc = "What it counts"
quantity = "beat.Count"
unit = "1"
check = { all_within = { at_least = 0 } }
observations_min = 20
"#;

/// Beats ten times a second. `{}` runs before each beat.
const BEAT: &str = r"
import ctypes, os, socket, struct, sys, time

bus = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
bus.bind((sys.argv[1],))
count = 0
while True:
    time.sleep(0.1)
    count += 1
    DOES
    bus.send(struct.pack('=IB3x8s', 0x123, 1, bytes([count % 256])))
";

pub fn project(does: &str) -> Hil {
    let hil = Hil::new();
    fs::create_dir(hil.path("rigs")).unwrap();
    fs::write(hil.path("rigs/beat.toml"), RIG).unwrap();
    fs::write(hil.path("beat.dbc"), DBC).unwrap();
    fs::write(hil.path("beats.toml"), PLAN).unwrap();
    fs::write(hil.path("beat.py"), BEAT.replace("DOES", does)).unwrap();
    hil
}

/// Lists the processes that run in this folder.
fn processes_in(folder: &Path) -> Vec<String> {
    let folder = folder.canonicalize().unwrap();
    let numbers = fs::read_dir("/proc").unwrap().filter_map(|entry| {
        let path = entry.unwrap().path();
        let is_there = fs::read_link(path.join("cwd")).ok()? == folder;
        is_there.then(|| fs::read_to_string(path.join("stat")).unwrap_or_default())
    });
    numbers.collect()
}

#[test]
fn a_program_that_does_not_end_in_order_is_noted() {
    for (handler, noted) in [
        ("sys.exit(7)", "`beat` ended with status 7 when it was asked to end"),
        ("os.abort()", "`beat` was killed by signal 6 (SIGABRT) when it was asked to end"),
        ("None", "`beat` did not end within 3 s of SIGTERM and was killed"),
        ("sys.exit(0)", ""),
    ] {
        let hil =
            project(&format!("import signal; signal.signal(signal.SIGTERM, lambda *_: {handler})"));
        hil.run(&["run", "beats.toml", "--out", "run"]).exits(0);
        let summary = fs::read_to_string(hil.path("run/summary.json")).unwrap();
        assert!(summary.contains(noted), "{summary}");
        assert_eq!(summary.contains("asked to end"), noted.contains("asked to end"), "{summary}");
    }
}

/// Nobody waits until the limit of a program that computes without end.
#[test]
fn ctrl_c_ends_a_run_whose_program_hangs() {
    let hil =
        project("if count == 5:\n        open('hung', 'w').close()\n        while True: pass");
    let rig = RIG.replace("wall_limit_s = 10", "wall_limit_s = 600");
    fs::write(hil.path("rigs/beat.toml"), rig).unwrap();
    let mut command = hil.command(&["run", "beats.toml", "--out", "run"]);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    wait_for("the program", || hil.path("hung").exists());
    signal(&child, Signal::INT);
    let ran = Ran::of(child.wait_with_output().unwrap()).exits(5);
    assert!(ran.out.contains("beats: aborted: stopped by request"), "{}", ran.out);
    assert_eq!(hil.outcome("run"), "aborted");
}

#[test]
fn each_end_of_a_program_is_named_and_none_of_its_processes_is_left() {
    for (does, status, named) in [
        ("pass", 0, "passed"),
        ("sys.exit('no more beats')", 1, "no more beats"),
        ("os.abort()", 1, "which is under test, was ended during the run by signal 6"),
        (
            "while True: pass",
            1,
            "which is under test, hung: it ran for 10 s of real time without waiting",
        ),
        (
            "import threading; lock = threading.Lock(); lock.acquire(); lock.acquire()",
            1,
            "which is under test, hung: its only thread waits for itself since 0.1 s",
        ),
        ("while True: os.fork()", 1, "the program started more than 8 processes"),
        ("if os.fork() == 0: time.sleep(1e6)", 1, "the program started more than 8 processes"),
        ("bus.recv(16)", 1, "1 unset"),
        (
            "close = ctypes.CDLL('libc.so.6').close; [close(fd) for fd in range(3, 1024)]",
            1,
            "the program closed the descriptor by which the shim speaks to the harness",
        ),
    ] {
        let hil = project(does);
        let ran = hil.run(&["run", "./beats.toml", "--out", "out"]);
        let words = format!("{} {}", ran.out, ran.err);
        let words = words.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(ran.status, Some(status), "{does}: {words}");
        assert!(words.contains(named), "{does}: {words}");
        let left = processes_in(&hil.path("."));
        assert!(left.is_empty(), "{does}: {left:?}");
    }
}

#[test]
fn a_program_whose_script_is_not_there_does_not_start() {
    let hil = project("pass");
    fs::remove_file(hil.path("beat.py")).unwrap();
    for clock in ["virtual", "real"] {
        let ran = hil.run(&["run", "./beats.toml", "--out", "out", "--clock", clock]).exits(3);
        let words = format!("{} {}", ran.out, ran.err);
        let words = words.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.contains("script `./beat.py` is not in"), "{clock}: {words}");
    }
}

#[test]
fn a_command_in_one_string_is_said_to_be_several_words() {
    let hil = project("pass");
    let apart = "\"python3\", \"./beat.py\", \"{can0}\"";
    let as_one = RIG.replace(apart, "\"python3 ./beat.py {can0}\"");
    assert_ne!(as_one, RIG);
    fs::write(hil.path("rigs/beat.toml"), as_one).unwrap();
    for clock in ["virtual", "real"] {
        let ran = hil.run(&["run", "./beats.toml", "--out", "out", "--clock", clock]).exits(3);
        let words = format!("{} {}", ran.out, ran.err);
        let words = words.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.contains("each argument are strings of their own"), "{clock}: {words}");
    }
}

/// Four seconds by the clock on the wall, which virtual time does not see.
#[test]
fn a_verdict_says_that_a_program_computed_longer_than_the_bench_ran() {
    let seconds = "u = lambda: float(open('/proc/uptime').read().split()[0])";
    let does = format!(
        "{seconds}; t = u() + 4 if count == 1 else 0\n    while u() < t: sum(range(100_000))"
    );
    let ran = project(&does).run(&["run", "./beats.toml", "--out", "out"]).exits(0);
    assert!(ran.err.contains("takes no virtual time") || ran.out.contains("takes no virtual time"));
}

#[test]
fn a_program_that_breaks_the_contract_is_told_with_the_first_difference() {
    let verify = |does: &str| {
        project(does).run(&["run", "./beats.toml", "--verify-determinism", "--out", "out"])
    };
    verify("pass").exits(0);
    // All beats but the first have random counts.
    let ran = verify("if count > 1: count = int.from_bytes(os.urandom(8), 'big')").exits(3);
    let words = format!("{} {}", ran.out, ran.err);
    let words = words.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words.contains("two runs of seed 1 differ: `0.2"), "{words}");
    assert!(words.contains(" beat frame 123#") && words.contains("and then `0.2"), "{words}");
}

#[test]
fn an_envelope_starts_the_program_afresh_for_each_run() {
    let hil = project("pass");
    let lossy = PLAN.replace("observations_min = 20", "observations_min = 25");
    fs::write(hil.path("beats.toml"), lossy).unwrap();
    let arguments = [
        "campaign",
        "./beats.toml",
        "--envelope",
        "drop",
        "--share",
        "0.5",
        "--runs",
        "5",
        "--quiet",
        "--out",
        "out",
    ];
    let ran = hil.run(&arguments).exits(0);
    let row = |severity: &str| {
        let mut rows = ran.out.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
        let row = rows.find(|row| row.first() == Some(&severity));
        row.map(|row| row[1..4].join(" ")).unwrap_or_default()
    };
    assert_eq!(row("0"), "5 of 5", "{}", ran.out);
    assert_eq!(row("0.01"), "5 of 5", "{}", ran.out);
    assert!(row("100").starts_with("0 of "), "{}", ran.out);
    assert!(ran.out.contains("tolerated up to "), "{}", ran.out);
    assert_eq!(hil.run(&arguments).exits(0).out, ran.out, "from the journal");
    // What another program did shows nothing of this one.
    fs::write(hil.path("beat.py"), BEAT.replace("DOES", "continue")).unwrap();
    let other = hil.run(&arguments).exits(2).err;
    assert!(other.contains("is of another campaign: program"), "{other}");
}

#[test]
fn limits_of_virtual_time_are_checked() {
    for (said, expected) in [
        ("wall_limit_s = 0.0", "`wall_limit_s` is 0.1 s to a day"),
        ("spin_step_s = 2.0", "`spin_step_s` is a nanosecond to a second"),
        ("processes_max = 0", "a program is one process at least"),
        ("patience_s = 1.0", "unknown field `patience_s`"),
    ] {
        let hil = project("pass");
        let rig = RIG.replace("wall_limit_s = 10, processes_max = 8", said);
        fs::write(hil.path("rigs/beat.toml"), rig).unwrap();
        let ran = hil.run(&["run", "./beats.toml"]).exits(2);
        assert!(ran.err.contains(expected), "{said}: {}", ran.err);
    }
}

/// The program asks for the time in a loop between its beats: a busy wait, whose steps the rig file sets.
#[test]
fn what_a_question_takes_is_a_setting() {
    let hil = project("due = time.monotonic() + 0.05\n    while time.monotonic() < due: pass");
    let run = |said: &str| {
        let rig = RIG.replace("wall_limit_s = 10, processes_max = 8", said);
        fs::write(hil.path("rigs/beat.toml"), rig).unwrap();
        hil.run(&["run", "./beats.toml", "--record", "full", "--quiet", "--out", "out"]).exits(1);
        hil.run(&["show", "out"]).exits(0).out
    };
    // The start asks often and takes time by that. From then on all beats are alike.
    let between_s = |shown: &str| {
        let at = |count: &str| {
            let line = shown.lines().find(|line| line.contains(count));
            let word = line.and_then(|line| line.split_whitespace().next());
            word.and_then(|word| word.parse::<f64>().ok()).unwrap_or_else(|| panic!("{shown}"))
        };
        at("frame 123#05") - at("frame 123#04")
    };
    let fine = run("spin_questions = 2_000, spin_step_s = 1e-5");
    assert!((between_s(&fine) - 0.15).abs() < 1e-3, "{fine}");
    let coarse = run("spin_questions = 2_000, spin_step_s = 0.04");
    // Two steps reach 50 ms, and one more is due to the question of `time.sleep` before it waits.
    assert!((between_s(&coarse) - 0.22).abs() < 1e-3, "{coarse}");
}

#[test]
fn a_rerun_says_what_it_has_started_and_takes_the_command_of_the_plan_that_is_named() {
    let hil = project("pass");
    hil.run(&["run", "./beats.toml", "--record", "full", "--out", "out"]).exits(0);
    fs::write(hil.path("other.py"), BEAT.replace("DOES", "count += 1")).unwrap();
    fs::write(hil.path("rigs/beat.toml"), RIG.replace("./beat.py", "./other.py")).unwrap();
    let recorded = hil.run(&["rerun", "out"]).exits(0).out;
    assert!(
        recorded.starts_with("started `beat`: python3 ./beat.py {can0} (as recorded;"),
        "{recorded}"
    );
    let changed = hil.run(&["rerun", "out", "--plan", "./beats.toml"]).exits(1).out;
    let said = "started `beat`: python3 ./other.py {can0} (by the rig of ./beats.toml)";
    assert!(changed.starts_with(said) && changed.contains("first difference"), "{changed}");
    fs::remove_file(hil.path("beat.py")).unwrap();
    let gone = hil.run(&["rerun", "out"]).exits(2).err;
    assert!(gone.contains("its script `./beat.py` is not in"), "{gone}");
}

/// The plan with these properties in place of its measurement.
fn with_properties(hil: &Hil, properties: &str) {
    let (head, _) = PLAN.split_once("\n[[measurement]]").unwrap();
    fs::write(hil.path("beats.toml"), format!("{head}\n{properties}")).unwrap();
}

const COUNTS: &str = "[[property]]\nname = \"counts\"\nalways = \"beat.Count >= 0\"\n";

const CAMPAIGN: &[&str] = &[
    "campaign",
    "./beats.toml",
    "--cases",
    "6",
    "--faults",
    "scheduler_stall",
    "--quiet",
    "--out",
    "found",
];

#[test]
fn a_campaign_of_a_program_that_says_nothing_shows_nothing() {
    let hil = project("continue");
    with_properties(&hil, COUNTS);
    let ran = hil.run(CAMPAIGN).exits(2);
    assert!(ran.err.contains("never judges the property counts, without any fault"), "{}", ran.err);
    let envelope = [
        &["campaign", "./beats.toml", "--envelope", "scheduler_stall"][..],
        &["--at-least", "0.1", "--share", "0.5", "--runs", "6", "--quiet"],
    ];
    let ran = hil.run(&envelope.concat()).exits(2);
    assert!(ran.err.contains("pass without the fault: 0 of 6"), "{}", ran.err);
}

#[test]
fn a_program_that_a_fault_ends_breaks_a_property_whatever_is_declared() {
    let late = "now = time.monotonic()\n    late = now - globals().get('then', now)\n    then = now\n    \
                if late > 0.3: sys.exit(7)";
    let hil = project(late);
    with_properties(&hil, COUNTS);
    let ran = hil.run(CAMPAIGN).exits(1);
    assert!(ran.out.contains("keeps_running: case "), "{}", ran.out);
    assert!(ran.out.contains("`beat`, which is under test, exited during"), "{}", ran.out);
    let smallest = fs::read_dir(hil.path("found")).unwrap().map(|entry| entry.unwrap().path());
    let smallest = smallest.filter(|path| path.to_string_lossy().contains("keeps-running"));
    let smallest: Vec<_> = smallest.collect();
    assert_eq!(smallest.len(), 1, "{smallest:?}");
    let again = hil.run(&["run", smallest[0].to_str().unwrap(), "--out", "again"]).exits(1);
    assert!(again.out.contains("`beat`, which is under test, exited during"), "{}", again.out);
}

#[test]
fn what_a_plan_demands_sometimes_some_case_reaches() {
    let hil = project("pass");
    let some = |limit: u32| format!("{COUNTS}[[property]]\nsometimes = \"beat.Count > {limit}\"\n");
    with_properties(&hil, &some(200));
    let ran = hil.run(CAMPAIGN).exits(1);
    let note = "the plan demands beat.Count > 200 sometimes, and no case reached it";
    assert!(ran.err.contains(note), "{}", ran.err);
    let junit = fs::read_to_string(hil.path("found/junit.xml")).unwrap();
    assert!(junit.contains("no case reached it") && junit.contains("failures=\"1\""), "{junit}");
    fs::remove_dir_all(hil.path("found")).unwrap();
    with_properties(&hil, &some(20));
    hil.run(CAMPAIGN).exits(0);
    // A condition that never came is not a test, and the campaign says so.
    fs::remove_dir_all(hil.path("found")).unwrap();
    let never =
        "[[property]]\nname = \"stops\"\nalways = \"beat.Count > 200 -> beat.Count < 202\"\n";
    with_properties(&hil, &format!("{COUNTS}{never}"));
    let ran = hil.run(CAMPAIGN).exits(0);
    assert!(ran.out.contains("stops: no case put it to the test"), "{}", ran.out);
}

#[test]
fn a_stall_in_which_a_program_was_to_send_has_struck() {
    let noted = |at_s: f64, for_s: f64| {
        let hil = project("pass");
        let fault = format!(
            "[[fault]]\ntarget = \"host\"\nwhat = {{ scheduler_stall = {{ for_s = {for_s} }} }}\nwhen = {{ at_s = {at_s} }}\n"
        );
        fs::write(hil.path("beats.toml"), format!("{PLAN}\n{fault}")).unwrap();
        let ran = hil.run(&["run", "./beats.toml", "--out", "out"]).exits(0);
        ran.out.contains("fault 0 changed nothing")
    };
    assert!(!noted(0.55, 0.3));
    assert!(noted(0.55, 0.01), "between two beats");
}
