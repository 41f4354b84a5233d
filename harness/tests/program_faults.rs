//! Faults of the machine of a program in virtual time: exact to the nanosecond, as those of the controller in the process.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]
#![cfg(feature = "programs")]

use harness::run::{Prepared, simulate};
use plan::made::Made;
use record::RecordKind;
use record::outcome::Outcome;
use record::sink::{Level, MemorySink};
use rig::operator::Answers;
use std::fs;

/// Says ten times a second, by its own clock, what that clock says, in milliseconds since the run began.
const BEAT: &str = r#"
import socket, struct, sys, time

bus = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
bus.bind((sys.argv[1],))
due = 0.0
while True:
    due += 0.1
    time.sleep(max(0.0, due - (time.monotonic() - 10_000)))
    clock = round((time.monotonic() - 10_000) * 1000)
    bus.send(struct.pack("=IB3xI4x", 0x123, 4, clock))
"#;

const DBC: &str = "VERSION \"\"\nBU_: Beat\nBO_ 291 Beat: 4 Beat\n SG_ Clock : 0|32@1+ (1,0) [0|0] \"\" Vector__XXX\n";

const RIG: &str = r#"
title = "A program alone"
[[line]]
name = "can0"
can = { bit_rate = 500_000, dbc = "../beat.dbc" }
[[node]]
name = "beat"
at = "can0"
under_test = { command = ["python3", "BEAT", "{can0}"] }
"#;

const PLAN: &str = r#"
name = "beats"
title = "A program beats"
rig = "beat"
steps = [{ wait = { duration_s = 3.05 } }]

[[measurement]]
name = "clock"
doc = "What it says"
quantity = "beat.Clock"
unit = "1"
check = { all_within = { at_least = 0 } }
"#;

/// When each beat was on the bus, and what the program's clock said, both in milliseconds; and how often the faults acted.
fn beats(faults: &str) -> (Vec<(i64, u32)>, u64) {
    beats_of(BEAT, faults)
}

fn beats_of(program: &str, faults: &str) -> (Vec<(i64, u32)>, u64) {
    beats_in(&format!("{PLAN}{faults}"), program)
}

fn beats_in(text: &str, program: &str) -> (Vec<(i64, u32)>, u64) {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::create_dir(path("rigs")).unwrap();
    fs::write(path("beat.py"), program).unwrap();
    fs::write(path("beat.dbc"), DBC).unwrap();
    fs::write(path("rigs/beat.toml"), RIG.replace("BEAT", path("beat.py").to_str().unwrap()))
        .unwrap();
    fs::write(path("beats.toml"), text).unwrap();
    let plan = path("beats.toml");
    let prepared = Prepared::load(plan.to_str().unwrap(), &Made::default()).unwrap();
    let mut sink = MemorySink::new(Level::Full);
    let run = simulate(&prepared, 1, &Answers::default(), &mut sink, &mut |_| true);
    assert_eq!(run.ending.outcome, Outcome::Passed, "{:?}", run.ending);
    let mut beats = Vec::new();
    for record in sink.into_records() {
        if let RecordKind::Frame(frame) = record.kind {
            let clock = u32::from_le_bytes(frame.data().try_into().unwrap());
            beats.push(((record.at.as_nanos() + 20_000) / 1_000_000, clock));
        }
    }
    (beats, run.faults.iter().map(|fault| fault.acted).sum())
}

fn every_100(from: u32, to: u32) -> impl Iterator<Item = (i64, u32)> {
    (from..=to).step_by(100).map(|ms| (i64::from(ms), ms))
}

#[test]
fn without_faults_it_beats_by_the_clock_of_the_bench() {
    assert_eq!(beats("").0, every_100(100, 3_000).collect::<Vec<_>>());
}

/// What was due meanwhile is done at the end, at once.
#[test]
fn a_program_that_is_not_scheduled_does_all_at_the_end_of_it() {
    let fault = "\n[[fault]]\ntarget = \"host\"\nwhat = { scheduler_stall = { for_s = 0.2 } }\nwhen = { at_s = 1.05 }\n";
    let stalled = [(1_250, 1_250), (1_250, 1_250)];
    let expected = every_100(100, 1_000).chain(stalled).chain(every_100(1_300, 3_000));
    assert_eq!(beats(fault).0, expected.collect::<Vec<_>>());
}

/// At 1.05 s its wall clock is half a second ahead, and at 2.05 s it is set back.
#[test]
fn a_clock_step_sets_the_wall_clock_alone() {
    let fault = "\n[[fault]]\ntarget = \"host\"\nwhat = { clock_step = { step_s = 0.5 } }\nwhen = { at_s = 1.05 }\nduration_s = 1\n";
    let (by_monotonic_clock, acted) = beats(fault);
    assert_eq!((by_monotonic_clock, acted), (every_100(100, 3_000).collect(), 1));
    let program = BEAT.replace("time.monotonic() - 10_000", "time.time() - 1_700_000_000");
    assert_ne!(program, BEAT);
    let (by_wall_clock, _) = beats_of(&program, fault);
    // The wait in progress is relative, and goes on. After it, six beats are due, which take a millisecond on the bus.
    let at_once = [[(1_100, 1_600); 5].as_slice(), &[(1_101, 1_600)]].concat();
    let ahead = (1_200..=2_000).step_by(100).map(|ms| (i64::from(ms), ms + 500));
    let expected = every_100(100, 1_000).chain(at_once).chain(ahead).chain([(2_100, 2_100)]);
    let expected = expected.chain(every_100(2_700, 3_000));
    assert_eq!(by_wall_clock, expected.collect::<Vec<_>>());
}

/// As on a bench: what it knew is gone, and its clocks went on.
#[test]
fn a_program_whose_supply_fails_is_started_again() {
    let program = BEAT.replace("due = 0.0", "due = time.monotonic() - 10_000");
    assert_ne!(program, BEAT);
    let expected: Vec<_> = every_100(100, 1_000).chain(every_100(2_170, 3_000)).collect();
    let fault = "\n[[fault]]\ntarget = \"beat\"\nwhat = { restart = { for_s = 1.02 } }\nwhen = { at_s = 1.05 }\n";
    assert_eq!(beats_of(&program, fault), (expected.clone(), 1));
    let (wait, cycle) =
        ("{ wait = { duration_s = 1 } }", "{ power_cycle = { device = \"beat\", off_s = 1.02 } }");
    let steps = format!("steps = [{{ wait = {{ duration_s = 1.05 }} }}, {cycle}, {wait}]");
    assert_eq!(
        beats_in(&PLAN.replace("steps = [{ wait = { duration_s = 3.05 } }]", &steps), &program),
        (expected, 0)
    );
}

/// It is off as long as anything cuts its supply, and it is not started again only to be stopped.
#[test]
fn a_supply_that_is_cut_twice_is_back_with_the_second() {
    let program = BEAT.replace("due = 0.0", "due = time.monotonic() - 10_000");
    let fault = |at_s: f64, for_s: f64| {
        format!(
            "\n[[fault]]\ntarget = \"beat\"\nwhat = {{ restart = {{ for_s = {for_s} }} }}\nwhen = {{ at_s = {at_s} }}\n"
        )
    };
    let step = "steps = [{ wait = { duration_s = 1.05 } }, { power_cycle = { device = \"beat\", off_s = 0.5 } }, { wait = { duration_s = 1.5 } }]";
    let plan = PLAN.replace("steps = [{ wait = { duration_s = 3.05 } }]", step);
    let expected: Vec<_> = every_100(100, 1_000).chain(every_100(2_170, 2_900)).collect();
    let faults = [fault(1.2, 0.87), fault(2.95, 60.0)].concat();
    assert_eq!(beats_in(&format!("{plan}{faults}"), &program), (expected, 2));
}

#[test]
fn where_nothing_runs_there_is_no_machine_to_strike() {
    let plan = r#"
name = "valve"
title = "A device alone"
device = "oven"
steps = [{ wait = { duration_s = 1 } }]
[[measurement]]
name = "heard"
doc = "It talks"
quantity = "signal.HeaterOn"
unit = "1"
check = { all_within = { at_least = 0 } }
[[fault]]
target = "host"
what = { scheduler_stall = { for_s = 0.2 } }
"#;
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("devices")).unwrap();
    let oven = r#"
name = "oven"
title = "An oven"
source = "a test"
[serial]
baud = 115200
[[message]]
name = "Status"
sent_by = "device"
start = [0xAA]
fields = [{ name = "HeaterOn", type = "u8" }]
period_s = 0.1
[signal.HeaterOn]
expression = "1"
"#;
    fs::write(folder.path().join("devices/oven.toml"), oven).unwrap();
    let path = folder.path().join("valve.toml");
    fs::write(&path, plan).unwrap();
    let error = Prepared::load(path.to_str().unwrap(), &Made::default()).unwrap_err();
    let text = format!("{error:?} {error}");
    assert!(text.contains("on this bench"), "{text}");
}
