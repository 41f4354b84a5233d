//! How a program without a C library may end: the same as one with it, and no process is left.

use crate::common::{
    bytes, compiled, drive, none_left_of, processes_of, secs, text, with_others_rights,
};
use lockstep::verify::Event;
use lockstep::{BinaryError, Ended, Lockstep, Program, StartError, State};
use std::os::unix::process::ExitStatusExt as _;
use std::time::Duration;
use wire::device::{Device as _, PortId};
use wire::time::{Span, Timestamp};

/// Long enough for what must be detected, short for the person who waits.
const LIMIT: Duration = Duration::from_millis(1_500);

fn odd(how: &str) -> Program {
    let path = compiled("gcc", "odd.c", &["-static", "-DIS_STATIC"]);
    Program::new([path.as_str(), how]).serial("/dev/ttyHIL0")
}

fn run(program: Program, seconds: i64) -> (Lockstep, Vec<Event>) {
    let mut running = program.start().unwrap();
    let events = drive(&mut running, secs(seconds), &[]);
    (running, events)
}

#[test]
fn a_status_and_a_signal_are_told() {
    let (running, _) = run(odd("crash"), 1);
    let Some(Ended::Exited(status)) = running.ended() else { panic!("{:?}", running.state()) };
    assert_eq!(status.signal(), Some(6));
    let (running, events) = run(odd("stdin").stdin("one\ntwo\n"), 1);
    assert_eq!(text(&events, 0), "one\ntwo\n");
    assert!(matches!(running.ended(), Some(Ended::Exited(status)) if status.success()));
}

#[test]
fn one_that_computes_without_end_is_given_up_and_none_of_it_is_left() {
    let path = compiled("gcc", "odd.c", &["-static", "-DIS_STATIC"]);
    let program = || Program::new([path.as_str(), "compute"]).serial("/dev/ttyHIL0");
    let (running, _) = run(program().wall_limit(LIMIT), 1);
    assert_eq!(running.ended(), Some(&Ended::NeverWaited { limit: LIMIT }));
    let (running, _) = run(Program::new([path.as_str(), "family"]).serial("/dev/ttyHIL0"), 2);
    let left = processes_of(&path);
    assert_eq!(left.len(), 3, "the program, its child and its grandchild: {left:?}");
    drop(running);
    none_left_of(&path);
}

#[test]
fn one_whose_threads_wait_for_each_other_is_named() {
    for (how, threads) in [("stuck on a mutex", 1), ("stuck on two", 2), ("stuck in a child", 2)] {
        let (running, _) = run(odd(how), 5);
        let is_named = matches!(running.ended(), Some(Ended::Deadlocked { threads: found, .. }) if *found == threads);
        assert!(is_named, "{how}: {:?}", running.state());
    }
    for how in ["stuck but for SIGTERM", "stuck beside a pipe"] {
        let (running, _) = run(odd(how), 5);
        assert_eq!(running.state(), State::WaitsForEver, "{how}");
    }
    let (_, events) = run(odd("stuck until a timer"), 5);
    assert_eq!(text(&events, 0), "given\na second\n");
}

#[test]
fn one_that_only_asks_gets_on() {
    let spin = |how, step| odd(how).spin_questions(100).spin_step(Span::from_micros(step));
    let (_, events) = run(spin("clock", 10), 1);
    assert_eq!((events[0].at.as_nanos(), text(&events, 0)), (5_000_000, "5 ms\n".to_owned()));
    let (_, events) = run(spin("clock", 3), 1);
    assert_eq!(events[0].at.as_nanos(), 5_001_000, "the next whole step");
    let mut running = spin("look", 50).start().unwrap();
    assert!(drive(&mut running, Timestamp::from_nanos(10_020_000), &[]).is_empty());
    running.receive(Timestamp::from_nanos(10_020_000), PortId(0), &bytes("x"));
    let events = drive(&mut running, secs(1), &[]);
    assert_eq!((text(&events, 0), events[0].at.as_nanos()), ("byte\n".to_owned(), 10_050_000));
}

#[test]
fn one_that_closes_all_that_it_does_not_know_goes_on() {
    let (running, events) = run(odd("close"), 2);
    assert_eq!(text(&events, 0), "a second\n");
    assert_eq!((events[0].at, running.state()), (secs(1), State::WaitsForEver));
}

#[test]
fn children_are_in_the_same_time() {
    let (running, events) = run(odd("daemon"), 3);
    assert_eq!(text(&events, 0), "daemon\ndaemon\ndaemon\n");
    assert_eq!(running.state(), State::Running);
    let (_, events) = run(odd("family"), 600);
    assert_eq!(text(&events, 0), "waited\n");
    // A shell, which loads the C library.
    let (_, events) = run(odd("popen"), 0);
    assert_eq!(text(&events, 0), "42\n");
}

#[test]
fn a_thread_that_is_left_alone_may_become_another_program() {
    let (running, events) = run(odd("alone").stdin("other\n"), 2);
    assert_eq!(text(&events, 0), "alone\nother\n");
    assert!(events.iter().all(|event| event.at == secs(1)));
    assert!(matches!(running.ended(), Some(Ended::Exited(status)) if status.success()));
}

#[test]
fn forking_without_end_is_stopped() {
    let path = compiled("gcc", "odd.c", &["-static", "-DIS_STATIC"]);
    let program = Program::new([path.as_str(), "fork"]).serial("/dev/ttyHIL0").processes_max(8);
    let (running, _) = run(program, 1);
    assert_eq!(running.ended(), Some(&Ended::TooManyProcesses { limit: 8 }));
    none_left_of(&path);
}

#[test]
fn one_with_others_rights_is_named_and_runs_without_them_where_one_starts_it() {
    let Some(privileged) = with_others_rights(&["-static"]) else { return };
    let refused = Program::new([privileged.as_str()]).start().unwrap_err();
    let is_named = matches!(&refused, StartError::Binary(BinaryError::Privileged(_)));
    assert!(is_named, "{refused:?}");
    let path = compiled("gcc", "odd.c", &["-static", "-DIS_STATIC"]);
    let program = Program::new([path.as_str(), "start", &privileged]).serial("/dev/ttyHIL0");
    let (running, _) = run(program, 2);
    assert_eq!(processes_of(&privileged).len(), 1);
    assert_eq!(running.next_wakeup(), secs(1_000), "it waits in the time of the bench");
    drop(running);
    none_left_of(&path);
    none_left_of(&privileged);
}

/// The tracer is the parent of the program, which cannot escape except by killing it.
#[test]
fn one_that_kills_the_tracer_is_named() {
    let path = compiled("gcc", "odd.c", &["-static", "-DIS_STATIC"]);
    let program = Program::new([path.as_str(), "parent"]).serial("/dev/ttyHIL0");
    let (running, _) = run(program.wall_limit(LIMIT), 2);
    let Some(Ended::Exited(status)) = running.ended() else { panic!("{:?}", running.state()) };
    assert_eq!(status.signal(), Some(9));
    none_left_of(&path);
}

#[test]
fn signals_come_at_their_time() {
    for (how, after_ms) in [("signal", 2_000), ("child", 250)] {
        let (_, events) = run(odd(how), 3);
        let times: Vec<i64> = events.iter().map(|event| event.at.as_nanos() / 1_000_000).collect();
        assert_eq!(text(&events, 0), "signal\npaused\na second\n", "{how}");
        assert_eq!(times, [after_ms, after_ms, after_ms + 1_000], "{how}");
    }
}

#[test]
fn one_that_is_stopped_may_still_say_something() {
    let mut running = odd("term").start().unwrap();
    drive(&mut running, secs(5), &[]);
    running.stop(secs(5), Span::from_secs(1));
    let (_, what) = running.transmit(secs(5)).unwrap();
    assert_eq!(what, bytes("bye\n"));
    let Some(Ended::Stopped(status)) = running.ended() else { panic!("{:?}", running.state()) };
    assert!(status.success());
    let mut running = odd("deaf").start().unwrap();
    drive(&mut running, secs(5), &[]);
    running.stop(secs(5), Span::from_secs(1));
    let Some(Ended::Stopped(status)) = running.ended() else { panic!("{:?}", running.state()) };
    assert_eq!(status.signal(), Some(9));
}
