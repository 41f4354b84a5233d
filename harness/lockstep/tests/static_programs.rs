//! Programs without a C library: the tracer runs them, with the same contract as the shim.

use crate::common::{
    Busy, base, c, compiled, drive, example, frame, go, go_with, gyro, same_each_time, secs,
    source, text,
};
use lockstep::verify::{Event, compare};
use lockstep::{Ended, Program};
use std::collections::BTreeSet;
use std::process::Command;
use wire::device::{Device as _, Transmit};
use wire::time::Span;

/// Two serial lines: a gyro, and a base.
fn two(words: &[&str]) -> Program {
    let ports = ["/dev/ttyHIL0", "/dev/ttyHIL1"];
    let words = words.iter().copied().chain(ports);
    Program::new(words).serial(ports[0]).serial(ports[1])
}

#[test]
fn a_static_program_sends_what_the_dynamic_one_sends_at_the_same_nanoseconds() {
    let with_shim = c("poll.c");
    let mut running = two(&[&with_shim]).start().unwrap();
    let expected = drive(&mut running, secs(40), &[gyro(0)]);
    assert_eq!(expected.len(), 40 * 50);
    let mut events = Vec::new();
    // At a fixed address, and position-independent.
    for kind in ["-static", "-static-pie"] {
        let with_tracer = compiled("gcc", "poll.c", &[kind]);
        events = same_each_time(2, 40, &[gyro(0)], || two(&[&with_tracer]));
        assert_eq!(compare(&events, &expected), None, "{kind}");
    }
    assert!(text(&events, 1).starts_with("1 1 0.0092 20000000\n"));
}

/// Its loader cannot preload a library built for glibc.
#[test]
fn a_program_that_loads_musl_sends_the_same() {
    if let Err(cause) = Command::new("musl-gcc").arg("--version").output() {
        return skips::skip_unless(
            "HIL_TESTS_NEED_MUSL",
            format!("no musl: {cause}"),
            "apt install musl-tools",
        );
    }
    let run = |path: &str| same_each_time(2, 20, &[gyro(0)], || two(&[path]));
    let with_shim = run(&c("poll.c"));
    for kind in ["-no-pie", "-static"] {
        let with_musl = run(&compiled("musl-gcc", "poll.c", &[kind]));
        assert_eq!(compare(&with_shim, &with_musl), None, "{kind}");
    }
}

#[test]
fn threads_and_a_condition_variable_as_through_the_shim() {
    let path = compiled("g++", "condition.cpp", &["-std=c++17", "-static"]);
    let events = same_each_time(2, 30, &[gyro(0)], || two(&[&path]));
    let through_shim = compiled("g++", "condition.cpp", &["-std=c++17"]);
    let mut running = two(&[&through_shim]).start().unwrap();
    let expected = drive(&mut running, secs(30), &[gyro(0)]);
    assert_eq!(compare(&events, &expected), None);
}

#[test]
fn goroutines_on_serial_lines() {
    let Some(path) = go("serial.go") else { return };
    let events = same_each_time(3, 15, &[gyro(0)], || two(&[&path]));
    let text = text(&events, 1);
    let ticks: Vec<(i64, i64)> = text
        .lines()
        .filter(|line| !line.starts_with("silence"))
        .map(|line| {
            let words: Vec<i64> = line.split(' ').filter_map(|word| word.parse().ok()).collect();
            (words[0], *words.last().unwrap())
        })
        .collect();
    // Each tick is exact to the nanosecond.
    let expected: Vec<(i64, i64)> = (1..=750).map(|tick| (tick, tick * 20_000_000)).collect();
    assert_eq!(ticks, expected);
    assert!(text.starts_with("1 1 0.0092 20000000 ") && text.contains("\nsilence 100\n"));
    // The order of a map is random, and the random numbers are the same.
    let orders: BTreeSet<&str> = text.lines().filter_map(|line| line.split(' ').nth(4)).collect();
    assert!(orders.len() > 1, "{orders:?}");
}

/// As `go build` makes it where there is a C compiler: it loads glibc, and its runtime makes its own system calls.
#[test]
fn go_with_the_c_library_as_without() {
    let run = |path: &str, shell: &str| {
        let words = ["sh", "-c", shell, path, "/dev/ttyHIL0", "can0", "can1", "none"];
        let words = if shell.is_empty() { &words[3..] } else { &words };
        let program = || {
            let program = Program::new(words.iter().copied()).serial("/dev/ttyHIL0");
            program.can("can0").can_fd("can1").env("GODEBUG", "netdns=cgo")
        };
        text(&same_each_time(2, 2, &[gyro(0)], program), 0)
    };
    let (Some(with), Some(without)) = (go_with("net.go", "1"), go("net.go")) else { return };
    let headers = Command::new("readelf").args(["-lW", &with]).output().unwrap().stdout;
    assert!(String::from_utf8_lossy(&headers).contains("/ld-linux-"), "it does not load glibc");
    let expected = run(&without, "");
    assert!(
        expected.starts_with(
            "[127.0.0.1] <nil>\n\
             &{1000 16 can0  up} <nil>\n\
             can0 <nil> []\n\
             &{1001 72 can1  up} <nil>\n\
             can1 <nil> []\n\
             <nil> route ip+net: no such network interface\n\
             can0 up <nil>\n\
             can1 up <nil>\n\
             lo up|loopback <nil>\n\
             came \"0.9190\\n\" 10000000\n"
        ),
        "{expected:.400}"
    );
    assert!(expected.contains("\ntick 20000000\n") && expected.contains("\ntick 2000000000\n"));
    assert_eq!(run(&with, ""), expected);
    // Started by a program with the shim.
    assert_eq!(run(&with, "\"$0\" \"$@\""), expected);
    assert_eq!(run(&with, "exec \"$0\" \"$@\""), expected);
}

#[test]
fn go_on_a_raw_can_socket() {
    let Some(path) = go("can.go") else { return };
    let words = [path.as_str(), "can0", "/dev/ttyHIL0"];
    let program = || Program::new(words).can("can0").serial("/dev/ttyHIL0");
    let events = same_each_time(4, 30, &[base(0)], program);
    let times = |id: u16| -> Vec<i64> {
        let is_it = |event: &&Event| matches!(event.what, Transmit::Frame(f) if frame(id, f.data()) == event.what);
        events.iter().filter(is_it).map(|event| event.at.as_nanos() / 1_000_000).collect()
    };
    assert_eq!(times(0x201), (1..=1_500).map(|k| k * 20).collect::<Vec<_>>());
    assert_eq!(times(0x701), (1..=600).map(|k| k * 50).collect::<Vec<_>>());
    assert_eq!(
        text(&events, 1),
        "200 1700000010000000000\n400 1700000020000000000\n600 1700000030000000000\n"
    );
}

#[test]
fn garbage_children_and_signals_of_go() {
    let Some(path) = go("work.go") else { return };
    let run = || {
        let mut running = Program::new([path.as_str()]).serial("/dev/ttyHIL0").start().unwrap();
        let mut events = drive(&mut running, secs(1), &[]);
        running.stop(secs(1), Span::from_secs(1));
        while let Some((port, what)) = running.transmit(secs(1)) {
            events.push(Event { at: secs(1), port, what });
        }
        let is_stopped =
            matches!(running.ended(), Some(Ended::Stopped(status)) if status.success());
        assert!(is_stopped, "{:?} {}", running.state(), running.last_words());
        events
    };
    let events = run();
    let text = text(&events, 0);
    let lines: Vec<&str> = text.lines().collect();
    assert!(
        lines[0].starts_with("processors 1 collected true order ") && lines[0].ends_with(" 20ms")
    );
    // The parent waits as long as the child sleeps.
    assert_eq!(lines[1], "child child <nil> 270ms");
    assert!(lines[2].starts_with("computed "));
    assert_eq!(lines[3..], ["alarm clock 270ms", "terminated 1s"]);
    let _busy = Busy::start();
    assert_eq!(compare(&events, &run()), None);
}

#[test]
fn threads_of_rust_as_through_the_shim() {
    let path = format!("{}/rust_threads-{}", env!("CARGO_TARGET_TMPDIR"), std::process::id());
    let built = Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()))
        .args(["--edition", "2024", "-O", "-C", "target-feature=+crt-static", "-o", &path])
        .arg(source("rust_threads.rs"))
        .status();
    assert!(built.unwrap().success(), "rust_threads.rs does not compile");
    let events = same_each_time(2, 30, &[gyro(0)], || two(&[&path]));
    let through_shim = example("rust_threads");
    let mut running = two(&[&through_shim]).start().unwrap();
    assert_eq!(compare(&events, &drive(&mut running, secs(30), &[gyro(0)])), None);
}
