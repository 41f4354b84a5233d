//! Badly behaved programs: each outcome has a name, and no process is left behind.

use crate::common::{
    c, compiled, drive, none_left, none_left_of, python_with, secs, text, with_others_rights,
};
use lockstep::verify::Event;
use lockstep::{BinaryError, Ended, Lockstep, Program, StartError, State};
use std::io::{BufRead as _, BufReader};
use std::os::unix::process::ExitStatusExt as _;
use std::process::{Command, Stdio};
use std::time::Duration;
use wire::device::{Device as _, PortId};
use wire::time::{Span, Timestamp};

/// Long enough for what must be detected, short for the person who waits.
const LIMIT: Duration = Duration::from_millis(1_500);

fn odd(how: &str) -> Program {
    Program::new([c("odd.c").as_str(), how]).serial("/dev/ttyHIL0")
}

/// Runs for this time, and returns the program in its state then.
fn run(program: Program, seconds: i64) -> (Lockstep, Vec<Event>) {
    let mut running = program.start().unwrap();
    let events = drive(&mut running, secs(seconds), &[]);
    (running, events)
}

fn ends_and_leaves_nothing(running: Lockstep) {
    let left = running.pids();
    drop(running);
    none_left(&left);
}

#[test]
fn a_static_program_runs_and_waits_in_virtual_time() {
    let path = compiled("gcc", "idle.c", &["-static"]);
    let (running, _) = run(Program::new([path.as_str()]), 999);
    assert_eq!((running.state(), running.next_wakeup()), (State::Running, secs(1_000)));
    let (running, _) = run(Program::new([path.as_str()]), 1_000);
    assert!(matches!(running.ended(), Some(Ended::Exited(status)) if status.success()));
    ends_and_leaves_nothing(running);
}

#[test]
fn static_programs_that_others_start_are_in_the_same_time() {
    let path = compiled("gcc", "idle.c", &["-static"]);
    let script = format!("sleep 1; {path} & exec {path}");
    let (running, _) = run(Program::new(["sh", "-c", &script]), 1_000);
    assert_eq!((running.state(), running.next_wakeup()), (State::Running, secs(1_001)));
    assert_eq!(running.pids().len(), 2);
    ends_and_leaves_nothing(running);
    let odd = compiled("gcc", "odd.c", &["-static", "-DIS_STATIC"]);
    // Signals sent to it arrive, and so does its status if it is awaited.
    let script = format!("{odd} term & sleep 3; kill $!; wait $!; echo $? >/dev/ttyHIL0");
    let (_, events) = run(Program::new(["bash", "-c", &script]).serial("/dev/ttyHIL0"), 4);
    assert_eq!(text(&events, 0), "a second\nbye\n0\n");
    assert_eq!(events.last().unwrap().at, secs(3));
    let Some(python) = python_with("subprocess") else { return };
    let script = format!(
        "import subprocess, time; s = time.time(); \
         r = subprocess.run(['{odd}', 'stdin'], input=b'word', stdout=2); \
         r = subprocess.run(['{odd}', 'crash']); \
         open('/dev/ttyHIL0', 'w').write(f'{{r.returncode}} {{time.time() - s}}')"
    );
    let words = [python.as_str(), "-c", &script];
    let (_, events) = run(Program::new(words).serial("/dev/ttyHIL0"), 1);
    assert_eq!(text(&events, 0), "word-6 0.0");
}

#[test]
fn a_program_that_becomes_a_static_one_by_its_descriptor_is_named() {
    let path = compiled("gcc", "idle.c", &["-static"]);
    let Some(python) = python_with("os") else { return };
    let script =
        format!("import os; os.execve(os.open('{path}', os.O_RDONLY), ['idle'], os.environ)");
    let (running, _) = run(Program::new([python.as_str(), "-c", &script]), 2);
    let Some(Ended::NeverJoined { executable, .. }) = running.ended() else {
        panic!("{:?}", running.state())
    };
    assert_eq!(*executable, path);
    ends_and_leaves_nothing(running);
}

#[test]
fn what_is_no_program_or_has_no_name_is_refused() {
    let start = |word: &str| Program::new([word]).start().unwrap_err();
    assert!(matches!(start("no-such-program"), StartError::Binary(BinaryError::Missing(_))));
    assert!(matches!(start("/etc/passwd"), StartError::Binary(BinaryError::Foreign(_))));
    assert!(matches!(Program::new([""; 0]).start(), Err(StartError::NoProgram)));
    let name = Program::new(["true"]).can("a name").start().unwrap_err();
    assert!(matches!(name, StartError::Name(_)));
}

#[test]
fn an_end_is_told_with_its_status() {
    let (running, _) = run(Program::new(["false"]), 1);
    let Some(Ended::Exited(status)) = running.ended() else { panic!("{:?}", running.state()) };
    assert_eq!(status.code(), Some(1));
    assert_eq!(running.next_wakeup(), Timestamp::MAX);
    let (running, _) = run(odd("crash"), 1);
    let Some(Ended::Exited(status)) = running.ended() else { panic!("{:?}", running.state()) };
    assert_eq!(status.signal(), Some(6));
}

#[test]
fn one_that_computes_without_end_is_given_up() {
    let (running, _) = run(odd("compute").wall_limit(LIMIT), 1);
    assert_eq!(running.ended(), Some(&Ended::NeverWaited { limit: LIMIT }));
    ends_and_leaves_nothing(running);
}

/// Nothing but the program itself could let it go on, so nobody has to wait for a limit.
#[test]
fn one_whose_threads_wait_for_each_other_is_named() {
    let deadlocked =
        |threads, ms| Ended::Deadlocked { threads, since: Timestamp::ZERO + Span::from_millis(ms) };
    for (how, threads, ms) in [
        ("stuck on a mutex", 1, 1_000),
        ("stuck on two", 2, 1_001),
        ("stuck in a child", 2, 1_001),
        ("stuck on what has ended", 1, 1_001),
        ("stuck on a semaphore", 1, 1_000),
    ] {
        let (running, _) = run(odd(how), 5);
        assert_eq!(running.ended(), Some(&deadlocked(threads, ms)), "{how}");
        ends_and_leaves_nothing(running);
    }
}

#[test]
fn one_that_something_else_can_wake_is_not_deadlocked() {
    for how in ["stuck but for SIGTERM", "stuck beside a pipe"] {
        let (running, _) = run(odd(how), 5);
        assert_eq!(running.state(), State::WaitsForEver, "{how}");
    }
    let (running, events) = run(odd("stuck until a timer"), 5);
    assert_eq!((text(&events, 0).as_str(), events[0].at), ("given\na second\n", secs(3)));
    assert_eq!(running.state(), State::WaitsForEver);
}

/// Its child stands still for it, as one under `strace` does, and nobody outside would let it go on.
#[test]
fn one_that_traces_another_of_its_own_is_given_up() {
    let (running, _) = run(odd("trace").wall_limit(LIMIT), 1);
    assert_eq!(running.ended(), Some(&Ended::NeverWaited { limit: LIMIT }));
    ends_and_leaves_nothing(running);
}

/// Holds a process as a debugger does while its user looks at it.
const HOLDS: &str = "
import ctypes, os, sys, time
ptrace = ctypes.CDLL(None, use_errno=True).ptrace
ptrace.argtypes = [ctypes.c_long] * 4
pid = int(sys.argv[1])
if ptrace(16, pid, 0, 0):
    sys.exit(os.strerror(ctypes.get_errno()))
os.waitpid(pid, 0)
print('held', flush=True)
time.sleep(2.5)
ptrace(17, pid, 0, 0)
";

/// A breakpoint triggers no time-out, neither of the program nor of the harness.
#[test]
fn one_that_a_debugger_holds_is_waited_for() {
    let mut running = odd("debug").wall_limit(LIMIT).start().unwrap();
    drive(&mut running, Timestamp::ZERO, &[]);
    let debugger = Command::new("python3")
        .args(["-c", HOLDS, &running.pids()[0].to_string()])
        .stdout(Stdio::piped())
        .spawn();
    let mut debugger = debugger.unwrap();
    let mut line = String::new();
    BufReader::new(debugger.stdout.take().unwrap()).read_line(&mut line).unwrap();
    assert_eq!(line, "held\n");
    let events = drive(&mut running, secs(2), &[]);
    assert_eq!((text(&events, 0).as_str(), events[0].at), ("a second\n", secs(1)));
    assert_eq!(running.state(), State::WaitsForEver);
    assert!(debugger.wait().unwrap().success());
}

#[test]
fn one_that_only_asks_for_the_time_gets_on() {
    let spin = |step| odd("clock").spin_questions(100).spin_step(Span::from_micros(step));
    let (_, events) = run(spin(10), 1);
    assert_eq!((events[0].at.as_nanos(), text(&events, 0)), (5_000_000, "5 ms\n".to_owned()));
    let (_, events) = run(spin(3), 1);
    assert_eq!(events[0].at.as_nanos(), 5_001_000, "the next whole step");
}

#[test]
fn one_that_looks_for_bytes_without_end_gets_on() {
    let mut running =
        odd("look").spin_questions(100).spin_step(Span::from_micros(50)).start().unwrap();
    assert!(drive(&mut running, Timestamp::from_nanos(10_020_000), &[]).is_empty());
    running.receive(Timestamp::from_nanos(10_020_000), PortId(0), &crate::common::bytes("x"));
    let events = drive(&mut running, secs(1), &[]);
    assert_eq!(text(&events, 0), "byte\n");
    assert_eq!(events[0].at.as_nanos(), 10_050_000);
}

#[test]
fn one_that_closes_all_that_it_does_not_know_goes_on() {
    let (running, events) = run(odd("close"), 2);
    assert_eq!(text(&events, 0), "a second\n");
    assert_eq!((events[0].at, running.state()), (secs(1), State::WaitsForEver));
    ends_and_leaves_nothing(running);
}

#[test]
fn a_daemon_goes_on_without_its_parent() {
    let (running, events) = run(odd("daemon"), 3);
    assert_eq!(text(&events, 0), "daemon\ndaemon\ndaemon\n");
    assert_eq!(running.state(), State::Running);
    ends_and_leaves_nothing(running);
}

#[test]
fn forking_without_end_is_stopped() {
    let path = c("odd.c");
    let program = Program::new([path.as_str(), "fork"]).serial("/dev/ttyHIL0").processes_max(8);
    let (running, _) = run(program, 1);
    assert_eq!(running.ended(), Some(&Ended::TooManyProcesses { limit: 8 }));
    none_left_of(&path);
}

/// The loader preloads nothing into a program with the rights of another user, and the kernel does not allow tracing
/// it.
#[test]
fn one_with_others_rights_is_named() {
    let Some(path) = with_others_rights(&[]) else { return };
    let refused = Program::new([path.as_str()]).start().unwrap_err();
    let is_named = matches!(&refused, StartError::Binary(BinaryError::Privileged(named)) if named.to_str() == Some(&path));
    assert!(is_named, "{refused:?}");
    let (running, _) =
        run(Program::new([c("odd.c").as_str(), "start", &path]).serial("/dev/ttyHIL0"), 2);
    let Some(Ended::NeverJoined { executable, .. }) = running.ended() else {
        panic!("{:?}", running.state())
    };
    assert_eq!(*executable, path);
    ends_and_leaves_nothing(running);
    none_left_of(&path);
}

#[test]
fn children_are_in_the_same_time_and_none_is_left() {
    let (running, events) = run(odd("family"), 600);
    assert_eq!(text(&events, 0), "waited\n");
    assert_eq!(running.pids().len(), 2, "the program and its grandchild");
    ends_and_leaves_nothing(running);
}

#[test]
fn programs_that_the_c_library_starts_are_waited_for() {
    let (_, events) = run(odd("popen"), 0);
    assert_eq!(text(&events, 0), "42\n");
    let Some(python) = python_with("subprocess") else { return };
    let script = "import subprocess, time; s = time.time(); \
                  r = subprocess.run(['sh', '-c', 'sleep 3; echo done'], capture_output=True, text=True); \
                  open('/dev/ttyHIL0', 'w').write(f'{r.stdout.strip()} {time.time() - s}')";
    let program = || Program::new([python.as_str(), "-c", script]).serial("/dev/ttyHIL0");
    let events = crate::common::same_each_time(2, 5, &[], program);
    assert_eq!(text(&events, 0), "done 3.0");
}

#[test]
fn signals_come_at_their_time() {
    let (_, events) = run(odd("signal"), 2);
    assert_eq!(text(&events, 0), "signal\npaused\n");
    assert!(events.iter().all(|event| event.at == secs(2)));
    let (_, events) = run(odd("child"), 1);
    assert_eq!(text(&events, 0), "signal\npaused\n");
}

#[test]
fn one_that_is_stopped_may_still_say_something() {
    let mut running = odd("term").start().unwrap();
    drive(&mut running, secs(5), &[]);
    running.stop(secs(5), Span::from_secs(1));
    let (_, what) = running.transmit(secs(5)).unwrap();
    assert_eq!(what, crate::common::bytes("bye\n"));
    let Some(Ended::Stopped(status)) = running.ended() else { panic!("{:?}", running.state()) };
    assert!(status.success());
    let mut running = odd("deaf").start().unwrap();
    drive(&mut running, secs(5), &[]);
    running.stop(secs(5), Span::from_secs(1));
    let Some(Ended::Stopped(status)) = running.ended() else { panic!("{:?}", running.state()) };
    assert_eq!(status.signal(), Some(9));
}

#[test]
fn standard_input_is_what_is_given() {
    let (running, events) = run(odd("stdin").stdin("one\ntwo\n"), 1);
    assert_eq!(text(&events, 0), "one\ntwo\n");
    assert!(matches!(running.ended(), Some(Ended::Exited(status)) if status.success()));
    let (_, events) = run(odd("stdin"), 1);
    assert!(events.is_empty());
}

#[test]
fn one_that_cuts_the_link_is_named() {
    for how in ["cut", "cut off"] {
        let (running, _) = run(odd(how).wall_limit(LIMIT), 5);
        assert_eq!(running.ended(), Some(&Ended::LinkClosed), "{how}");
        ends_and_leaves_nothing(running);
    }
}

#[test]
fn processes_that_keep_one_another_busy_are_stopped() {
    let (running, _) = run(odd("circle"), 1);
    assert_eq!(running.ended(), Some(&Ended::NeverAdvanced));
    ends_and_leaves_nothing(running);
}

/// Tells the test below that it will be killed.
const TO_BE_KILLED: &str = "HIL_TESTS_LOCKSTEP_TO_BE_KILLED";

#[test]
fn none_outlives_the_harness() {
    if std::env::var_os(TO_BE_KILLED).is_some() {
        // A program that computes cannot notice by itself.
        let mut running = odd("compute").start().unwrap();
        println!("pid {}.", running.pids()[0]);
        running.wake(Timestamp::ZERO);
        return;
    }
    // A killed process does not clean up.
    let folder = tempfile::tempdir().unwrap();
    let mut harness = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "odd::none_outlives_the_harness", "--nocapture"])
        .env(TO_BE_KILLED, "yes")
        .env("TMPDIR", folder.path())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let pid = BufReader::new(harness.stdout.take().unwrap()).lines().find_map(|line| {
        let line = line.unwrap();
        let (_, rest) = line.split_once("pid ")?;
        rest.trim_end_matches('.').parse::<i32>().ok()
    });
    harness.kill().unwrap();
    harness.wait().unwrap();
    let pid = pid.unwrap();
    // A process that is killed ends once it is scheduled, which takes its time on a busy machine.
    for _ in 0..1_200 {
        if std::panic::catch_unwind(|| none_left(&[pid])).is_ok() {
            return;
        }
        std::thread::park_timeout(Duration::from_millis(50));
    }
    none_left(&[pid]);
}
