//! Programs on CAN, on a kernel that need not support it.

use crate::common::{
    base, c, compiled, drive, frame, has_tool, none_left, python_with, same_each_time, secs,
    source, text,
};
use lockstep::verify::Event;
use lockstep::{Ended, Output, Program};
use std::sync::{Arc, Mutex};
use wire::can::{CanFrame, FdFlags, StandardId};
use wire::device::{Device as _, PortId, Transmit};
use wire::time::{Span, Timestamp};

fn python_can(name: &str) -> Option<Vec<Event>> {
    let python = python_with("can")?;
    let script = source(name);
    let words = [python.as_str(), script.to_str().unwrap()];
    let program = || Program::new(words).can("can0").env("PYTHONHASHSEED", "0");
    Some(same_each_time(3, 60, &[base(0)], program))
}

fn times_of(events: &[Event], id: u16) -> Vec<i64> {
    let like = |event: &&Event| matches!(event.what, Transmit::Frame(f) if frame(id, f.data()) == event.what);
    events.iter().filter(like).map(|event| event.at.as_nanos()).collect()
}

#[test]
fn python_can_with_a_notifier_and_a_cyclic_frame() {
    let Some(events) = python_can("notifier.py") else { return };
    let cyclic = times_of(&events, 0x701);
    let seconds: Vec<i64> = (0..=60).map(|second| second * 1_000_000_000).collect();
    assert_eq!(cyclic, seconds);
    let answers = times_of(&events, 0x201);
    assert_eq!(answers[..3], [20_000_000, 40_000_000, 60_000_000]);
    // The first frame has come, and its timestamp is bench time: its age is zero.
    let first = events.iter().find(|event| times_of(&[**event], 0x201) == [20_000_000]).unwrap();
    assert_eq!(first.what, frame(0x201, &[0, 0, 0, 1, 0, 0, 0, 0]));
}

#[test]
fn python_can_with_asyncio() {
    let Some(events) = python_can("asynchronous.py") else { return };
    assert_eq!(times_of(&events, 0x202)[..2], [15_000_000, 20_000_000]);
}

/// Runs a program for a number of seconds; returns what it sent and what it printed.
fn printed(
    words: &[&str],
    seconds: i64,
    streams: &[crate::common::Stream],
) -> (Vec<Event>, String) {
    let heard = Arc::new(Mutex::new(Vec::new()));
    let kept = Arc::clone(&heard);
    let sink = move |bytes: &[u8]| kept.lock().unwrap().extend_from_slice(bytes);
    let program =
        Program::new(words.iter().copied()).can("can0").output(Output::Sink(Box::new(sink)));
    let mut running = program.start().unwrap();
    let left = running.pids();
    let events = drive(&mut running, secs(seconds), streams);
    drop(running);
    none_left(&left);
    let text = String::from_utf8(heard.lock().unwrap().clone()).unwrap();
    (events, text)
}

#[test]
fn candump_prints_what_comes_with_its_time() {
    if !has_tool("candump") {
        return;
    }
    let words = ["candump", "-t", "a", "-L", "can0,181:7FF"];
    let (_, text) = printed(&words, 1, &[base(0)]);
    assert!(text.starts_with("(1700000000.020000) can0 181#00000001\n"), "{text}");
    assert_eq!(text.lines().count(), 50);
    // The inverted filter lets nothing pass.
    let (_, text) = printed(&["candump", "-L", "can0,181~7FF"], 1, &[base(0)]);
    assert_eq!(text, "");
}

#[test]
fn cansend_sends_one_frame_and_ends() {
    if !has_tool("cansend") {
        return;
    }
    let (events, _) = printed(&["cansend", "can0", "123#DEADBEEF"], 1, &[]);
    let at = Timestamp::ZERO;
    let what = frame(0x123, &[0xde, 0xad, 0xbe, 0xef]);
    assert_eq!(events, [Event { at, port: PortId(0), what }]);
}

#[test]
fn cangen_keeps_its_gap() {
    if !has_tool("cangen") {
        return;
    }
    let words = ["cangen", "can0", "-g", "10", "-I", "42", "-L", "1", "-D", "i", "-n", "5"];
    let (events, _) = printed(&words, 1, &[]);
    assert_eq!(times_of(&events, 0x42), [0, 10_000_000, 20_000_000, 30_000_000, 40_000_000]);
}

#[test]
fn processes_of_one_program_hear_one_another() {
    if !has_tool("candump") || !has_tool("cansend") {
        return;
    }
    let script = "candump -L -n 2 can0 & sleep 0.5; cansend can0 001#11; cansend can0 002#22; wait; echo ended";
    let (events, text) = printed(&["bash", "-c", script], 2, &[]);
    assert_eq!(events.len(), 2, "{text}");
    assert!(text.contains(" can0 001#11\n") && text.ends_with("ended\n"), "{text}");
}

/// Error frames reach the sockets whose filter asks for them; while bus-off, what is written is lost.
#[test]
fn error_frames_come_as_the_filter_of_a_socket_says() {
    for arguments in [&[][..], &["-static"]] {
        let path = compiled("gcc", "errors.c", arguments);
        let mut running = Program::new([path]).can("can0").serial("/dev/ttyHIL0").start().unwrap();
        let at = |ms| Timestamp::ZERO + Span::from_millis(ms);
        let mut events = drive(&mut running, at(21), &[]);
        for (ms, id, data) in
            [(25, 0x204, [0, 0x20, 0, 0, 0, 0, 128, 3]), (45, 0x040, [0; 8]), (75, 0x100, [0; 8])]
        {
            events.extend(drive(&mut running, at(ms), &[]));
            running.error_frame(at(ms), PortId(0), id, data);
        }
        events.extend(drive(&mut running, at(95), &[]));
        assert_eq!(text(&events, 1), "a 204 20 128 3\na 40 0 0 0\nb 40 0 0 0\na 100 0 0 0\n");
        let times: Vec<i64> =
            times_of(&events, 0x123).into_iter().map(|at| at / 1_000_000).collect();
        assert_eq!(times, [10, 20, 30, 40, 80, 90]);
    }
}

#[test]
fn a_frame_at_the_wrong_port_is_lost_and_counted() {
    let mut running = Program::new(["sleep", "1"]).can("can0").start().unwrap();
    running.receive(Timestamp::ZERO, PortId(1), &frame(1, &[]));
    assert_eq!(running.lost(), 1);
    running.receive(Timestamp::ZERO, PortId(0), &frame(1, &[]));
    assert_eq!(running.next_wakeup(), Timestamp::ZERO, "it is to hear it");
    assert_eq!(running.transmit(Timestamp::ZERO), None);
    assert_eq!(running.next_wakeup(), secs(1));
    running.wake(secs(1));
    assert!(matches!(running.ended(), Some(Ended::Exited(status)) if status.success()));
}

const SOCKETS: &str = "\
names: 0 can1
write: 16
sendto: 16
write: 16
nowhere: -1 1
fd: -1 1
all: 100l@0.001500
one: 100o
other: 101l
but 100:
nothing:
bcm: 0 1 0
cyclic: 200l@0.001500 200l@0.011500 200l@0.021500 200l@0.046500 200l@0.071500 200l@0.096500
rx: 11:-1 12:1 12:2
rest: 300@0.300000 300@0.310000 300@0.320000
many: 2 2 400:16 401:16
";

#[test]
fn sockets_do_what_those_of_the_kernel_do() {
    sockets_do_the_same(&c("sockets.c"));
}

#[test]
fn sockets_of_a_static_program_do_what_those_of_the_kernel_do() {
    sockets_do_the_same(&compiled("gcc", "sockets.c", &["-static"]));
}

fn sockets_do_the_same(path: &str) {
    let program = Program::new([path]).serial("/dev/ttyHIL0").can("can0").can("can1");
    let mut running = program.start().unwrap();
    let at = |ms: i64| Timestamp::from_nanos(ms * 1_000_000);
    let mut events = Vec::new();
    // The same frame twice is one change.
    for (ms, data) in [(300, 1), (310, 1), (320, 2)] {
        events.extend(drive(&mut running, at(ms), &[]));
        running.receive(at(ms), PortId(1), &frame(0x300, &[data]));
        while let Some((port, what)) = running.transmit(at(ms)) {
            events.push(Event { at: at(ms), port, what });
        }
    }
    assert!(matches!(running.ended(), Some(Ended::Exited(status)) if status.success()));
    assert_eq!(text(&events, 0), SOCKETS);
    let frames = |port| {
        let is_frame = |event: &&Event| event.port == PortId(port);
        events.iter().filter(is_frame).map(|event| event.at.as_nanos() / 1_000).collect::<Vec<_>>()
    };
    let frames_1 = [1_500, 1_500, 11_500, 21_500, 46_500, 71_500, 96_500, 320_000, 320_000];
    assert_eq!(frames(1), frames_1);
    assert_eq!(frames(2), [1_500, 1_500]);
}

fn fd(id: u16, bits: u8, data: &[u8]) -> Transmit {
    let id = StandardId::new(id).unwrap();
    Transmit::Frame(CanFrame::fd(id, FdFlags::from_bits(bits), data).unwrap())
}

/// 64 bytes at 50 Hz, with a counter in the last one; every second frame is a classic one.
fn long_frames() -> crate::common::Stream {
    let what = |k: i64| {
        let mut data = [0x5a; 64];
        data[63] = k as u8;
        if k % 2 == 0 { frame(0x181, &data[..8]) } else { fd(0x181, 1, &data) }
    };
    crate::common::Stream { what, ..base(0) }
}

#[test]
fn python_can_with_fd_frames() {
    let Some(python) = python_with("can") else { return };
    let script = source("fd.py");
    let words = [python.as_str(), script.to_str().unwrap()];
    let program = || Program::new(words).can_fd("can0").env("PYTHONHASHSEED", "0");
    let events = same_each_time(3, 10, &[long_frames()], program);
    let own: Vec<u8> = (0..24).collect();
    let times: Vec<i64> = events
        .iter()
        .filter(|event| event.what == fd(0x702, 1, &own))
        .map(|event| event.at.as_nanos() / 1_000_000)
        .collect();
    assert_eq!(times[..3], [0, 500, 1_000]);
    let answers: Vec<&Transmit> = events
        .iter()
        .map(|event| &event.what)
        .filter(|what| matches!(what, Transmit::Frame(frame) if frame.id() == id(0x203)))
        .collect();
    assert_eq!(answers.len(), 250, "one for each of CAN FD");
    let third = [64, 1, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    assert_eq!(*answers[2], fd(0x203, 0, &third));
}

fn id(raw: u16) -> wire::can::Id {
    StandardId::new(raw).unwrap().into()
}

#[test]
fn can_utils_with_fd_frames() {
    if !has_tool("candump") || !has_tool("cansend") {
        return;
    }
    let script = "candump -L -n 3 can0 & sleep 0.03; cansend can0 123##1112233; wait; cansend can1 123##0AA; echo $?";
    let heard = Arc::new(Mutex::new(Vec::new()));
    let kept = Arc::clone(&heard);
    let sink = move |bytes: &[u8]| kept.lock().unwrap().extend_from_slice(bytes);
    let program = Program::new(["bash", "-c", script]).can_fd("can0").can("can1");
    let mut running = program.output(Output::Sink(Box::new(sink))).start().unwrap();
    let events = drive(&mut running, secs(2), &[long_frames()]);
    drop(running);
    let text = String::from_utf8(heard.lock().unwrap().clone()).unwrap();
    let sent: Vec<&Transmit> = events.iter().map(|event| &event.what).collect();
    assert_eq!(sent, [&fd(0x123, 1, &[0x11, 0x22, 0x33])], "{text}");
    // The flags include the CAN FD mark (4), as in kernels from 5.14 on.
    let long = format!("can0 181##5{}01", "5A".repeat(63));
    assert!(text.contains(&long), "{text}");
    assert!(text.contains("can0 181#5A5A5A5A5A5A5A5A\n"), "{text}");
    assert!(text.contains("can0 123##5112233\n"), "{text}");
    // The other interface is a classic one.
    assert!(text.ends_with("1\n"), "{text}");
}

#[test]
fn programs_in_c_with_fd_frames() {
    for kind in ["-static", "-pie"] {
        let path = compiled("gcc", "echo_fd.c", &[kind]);
        let program = || Program::new([path.as_str()]).can_fd("can0");
        let events = same_each_time(2, 1, &[long_frames()], program);
        let answer = |k: usize| {
            let mut data = [0x5a; 64];
            data[0] = k as u8;
            (20 * k as i64, fd(0x182, 1, &data))
        };
        let expected: Vec<_> = (1..=50).step_by(2).map(answer).collect();
        let sent = events.iter().map(|event| (event.at.as_nanos() / 1_000_000, event.what));
        assert_eq!(sent.collect::<Vec<_>>(), expected, "{kind}");
    }
}

/// musl comes without the headers of the kernel.
const MUSL: [&str; 4] =
    ["-idirafter", "/usr/include", "-idirafter", "/usr/include/x86_64-linux-gnu"];

/// Where a kernel lists its interfaces, ours are among them.
#[test]
fn interfaces_are_listed() {
    let libc = ["can0 1000 up running 0 0\n", "can1 1001 up running 0 0\n"].concat();
    let kernel = ["can0 1000 up running 280 16\n", "can1 1001 up running 280 72\n"].concat();
    let expected =
        ["index 1000\ncan0 1000\ncan1 1001\n", &libc, &libc, &kernel, &kernel, "loopback 1\n"]
            .concat();
    let mut paths = vec![c("interfaces.c"), compiled("gcc", "interfaces.c", &["-static"])];
    if std::process::Command::new("musl-gcc").arg("--version").output().is_ok() {
        paths.push(compiled("musl-gcc", "interfaces.c", &MUSL));
    }
    for path in paths {
        let program = Program::new([path.as_str(), "/dev/ttyHIL0"]).serial("/dev/ttyHIL0");
        let mut running = program.can("can0").can_fd("can1").start().unwrap();
        let events = drive(&mut running, secs(1), &[]);
        assert_eq!(text(&events, 0), expected, "{path} {}", running.last_words());
    }
}
