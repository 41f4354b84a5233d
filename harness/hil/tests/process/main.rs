//! The process as its user sees it: ports, missions, reports, log, exit status.

#![cfg(unix)]
#![expect(clippy::unwrap_used, reason = "in a test what cannot go on may panic")]

mod child;
mod client;
mod devices;
mod pty;

use child::Process;
use controller::health::Level;
use controller::mission::{AbortReason, MissionResult, Report};
use devices::{BIAS_DEG_PER_S, base, gyro};
use rustix::process::Signal;
use skips::{Vcan0, in_time};
use std::path::{Path, PathBuf};
use wire::base::Request;

const BIAS_TEST: &str = "{\"id\":1,\"command\":{\"bias_test\":{\"duration_s\":0.5}}}\n";
const LONG_STRAIGHT: &str =
    "{\"id\":2,\"command\":{\"straight\":{\"distance_m\":50.0,\"speed_m_per_s\":0.2}}}\n";

/// Matches the answer to mission `id`.
fn answer(id: u32) -> impl FnMut(&Report) -> Option<Report> {
    move |report| match report {
        Report::Done { id: of, .. }
        | Report::Refused { id: of, .. }
        | Report::Aborted { id: of, .. }
            if *of == id =>
        {
            Some(*report)
        }
        _ => None,
    }
}

fn serial(base: &pty::Device) -> String {
    format!("serial:{}", base.port)
}

/// A link to a port, as a path and as text. A device that goes takes its link with it: the number of its pty may be that of
/// another test's next, which a controller that looks for its port would then open.
fn linked(folder: &Path, port: &str) -> (PathBuf, String) {
    let link = folder.join("gyro");
    std::os::unix::fs::symlink(port, &link).unwrap();
    let text = link.to_str().unwrap().to_owned();
    (link, text)
}

/// A process whose base is moving.
fn driving(gyro_port: &str, base: &str) -> Process {
    let mut process = Process::start(&["--gyro", gyro_port, "--base", base]);
    // The first messages of both devices have arrived.
    process.wait_for(|report| {
        matches!(report, Report::Health(health) if health.level == Level::Degraded).then_some(())
    });
    process.say(BIAS_TEST);
    let tested = process.wait_for(answer(1));
    assert!(matches!(tested, Report::Done { .. }), "{tested:?}");
    process.say(LONG_STRAIGHT);
    let ended = process.wait_for(|report| match report {
        Report::State(state) if state.moving && state.displacement.m() > 0.02 => Some(None),
        Report::Aborted { id: 2, .. } | Report::Refused { id: 2, .. } => Some(Some(*report)),
        _ => None,
    });
    assert_eq!(ended, None, "the base never got on its way");
    process
}

fn assert_stopped_and_at_rest(requests: &devices::Requests, reports: &[Report]) {
    assert_eq!(requests.lock().unwrap().last(), Some(&Request::Stop));
    let aborted = Report::Aborted { id: 2, reason: AbortReason::Stopped };
    assert!(reports.contains(&aborted), "{reports:?}");
    let last = reports.iter().rev().find_map(|report| match report {
        Report::State(state) => Some(state.moving),
        _ => None,
    });
    assert_eq!(last, Some(false));
    assert!(!reports.iter().any(|report| matches!(report, Report::Done { .. })));
}

#[test]
fn a_bias_test_runs_on_a_gyro_alone() {
    in_time(|| {
        let gyro = gyro(b"");
        let mut process = Process::start(&["--gyro", &gyro.port]);
        process.wait_for(|report| matches!(report, Report::State(_)).then_some(()));
        process.say(BIAS_TEST);
        let Report::Done { result: MissionResult::BiasTest(result), .. } =
            process.wait_for(answer(1))
        else {
            panic!("not done")
        };
        // One step of the Navigator stream is 0.00305 deg/s.
        assert!((result.mean.deg_per_s() - BIAS_DEG_PER_S).abs() < 0.002, "{result:?}");
        assert!((30..=51).contains(&result.samples), "{result:?}");
        process.close_stdin();
        let (status, _, log) = process.wait();
        assert_eq!(status, Some(0), "{log}");
    });
}

#[test]
fn stdin_closed_brings_the_base_to_rest() {
    in_time(|| {
        let (gyro, (base, requests)) = (gyro(b""), base(b""));
        let mut process = driving(&gyro.port, &serial(&base));
        process.close_stdin();
        let (status, reports, log) = process.wait();
        assert_eq!(status, Some(0), "{log}");
        assert!(log.contains("stdin was closed"), "{log}");
        assert_stopped_and_at_rest(&requests, &reports);
    });
}

/// Clients one after the other over a socket: each gets a new controller, and the base stops when one leaves.
#[test]
fn missions_come_from_one_client_after_the_other() {
    in_time(|| {
        let (gyro, (base, requests)) = (gyro(b""), base(b""));
        let folder = std::env::temp_dir().join(format!("k2a-listen-{}", std::process::id()));
        let place = format!("unix:{}", folder.display());
        let base_port = serial(&base);
        let arguments = ["--gyro", &gyro.port, "--base", &base_port, "--listen", &place];
        let process = Process::start(&arguments);
        let both_heard = |report: &Report| {
            matches!(report, Report::Health(health) if health.level == Level::Degraded)
                .then_some(())
        };
        let mut first = client::Client::connect(&folder);
        first.wait_for(both_heard);
        first.say(BIAS_TEST);
        assert!(matches!(first.wait_for(answer(1)), Report::Done { .. }));
        first.say(LONG_STRAIGHT);
        first.wait_for(|report| match report {
            Report::State(state) if state.moving => Some(()),
            _ => None,
        });
        drop(first);
        // The second waits until the base of the first is at rest.
        let mut second = client::Client::connect(&folder);
        second.wait_for(both_heard);
        let state = second.wait_for(|report| match report {
            Report::State(state) => Some(*state),
            _ => None,
        });
        assert!(!state.moving, "{state:?}");
        assert_eq!(requests.lock().unwrap().last(), Some(&Request::Stop));
        // New: without the bias that the first has found.
        assert_eq!(state.bias.rad_per_s(), 0.0, "{state:?}");
        second.say(BIAS_TEST);
        assert!(matches!(second.wait_for(answer(1)), Report::Done { .. }));
        process.signal(Signal::TERM);
        let (status, _, log) = process.wait();
        assert_eq!(status, Some(0), "{log}");
        assert!(!folder.exists(), "the socket is left over");
    });
}

#[cfg(target_os = "linux")]
#[test]
fn a_base_on_can_is_driven_and_brought_to_rest() {
    in_time(|| {
        let Some(_bus) = Vcan0::take("--test process -- a_base_on_can") else { return };
        let (_base, requests) = devices::can_base(Vcan0::NAME);
        let gyro = gyro(b"");
        let mut process = driving(&gyro.port, "can:vcan0");
        process.close_stdin();
        let (status, reports, log) = process.wait();
        assert_eq!(status, Some(0), "{log}");
        assert_stopped_and_at_rest(&requests, &reports);
    });
}

#[test]
fn a_signal_brings_the_base_to_rest() {
    in_time(|| {
        for (signal, name) in
            [(Signal::TERM, "SIGTERM"), (Signal::INT, "SIGINT"), (Signal::HUP, "SIGHUP")]
        {
            let (gyro, (base, requests)) = (gyro(b""), base(b""));
            let process = driving(&gyro.port, &serial(&base));
            process.signal(signal);
            let (status, reports, log) = process.wait();
            assert_eq!(status, Some(0), "{log}");
            assert!(log.contains(name), "{log}");
            assert_stopped_and_at_rest(&requests, &reports);
        }
    });
}

#[test]
fn stdout_closed_brings_the_base_to_rest() {
    in_time(|| {
        let (gyro, (base, requests)) = (gyro(b""), base(b""));
        let mut process = driving(&gyro.port, &serial(&base));
        process.close_stdout();
        let (status, _, log) = process.wait();
        assert_eq!(status, Some(0), "{log}");
        assert!(log.contains("stdout was closed"), "{log}");
        assert_eq!(requests.lock().unwrap().last(), Some(&Request::Stop));
    });
}

#[test]
fn a_moment_without_the_processor_is_not_silence() {
    in_time(|| {
        let gyro = gyro(b"");
        let mut process = Process::start(&["--gyro", &gyro.port]);
        process.wait_for(|report| {
            matches!(report, Report::State(state) if state.samples > 0).then_some(())
        });
        for _ in 0..5 {
            process.signal(Signal::STOP);
            // Three times the time-out of the gyro.
            process.rest(std::time::Duration::from_millis(300));
            process.signal(Signal::CONT);
            process.rest(std::time::Duration::from_millis(50));
        }
        process.close_stdin();
        let (status, reports, log) = process.wait();
        assert_eq!(status, Some(0), "{log}");
        let silent =
            |report: &Report| matches!(report, Report::Health(health) if health.causes.gyro_silent);
        assert!(!reports.iter().any(silent), "{reports:?}");
    });
}

#[test]
fn a_base_that_does_not_answer_is_told_in_the_status() {
    in_time(|| {
        let gyro = gyro(b"");
        let mute = pty::Device::spawn(|line, _| {
            line.read();
        });
        let mut process = Process::start(&["--gyro", &gyro.port, "--base", &serial(&mute)]);
        process.close_stdin();
        let (status, _, log) = process.wait();
        assert_eq!(status, Some(1), "{log}");
        assert!(log.contains("has not said in 2 s that it is at rest"), "{log}");
    });
}

#[test]
fn garbage_on_both_ports_hurts_nobody() {
    in_time(|| {
        const NOISE: &[u8] = b"\xff\x00\x80:;0F\r\n\x7f\xfe";
        let (gyro, (base, requests)) = (gyro(NOISE), base(NOISE));
        let mut process = driving(&gyro.port, &serial(&base));
        process.say("{\"id\":9,\"command\":\"stop\"}\n");
        process.wait_for(answer(9));
        process.close_stdin();
        let (status, _, log) = process.wait();
        assert_eq!(status, Some(0), "{log}");
        assert!(!log.contains("panicked"), "{log}");
        assert_eq!(requests.lock().unwrap().last(), Some(&Request::Stop));
    });
}

#[test]
fn garbage_on_stdin_is_counted_and_the_next_mission_answered() {
    in_time(|| {
        let gyro = gyro(b"");
        let mut process = Process::start(&["--gyro", &gyro.port]);
        process.say("{\"id\":1,\"command\"\n\n\x1b[2J\n{\"id\":1,\"command\":\"fly\"}\n");
        process.say(b"\xff\xfe\n");
        process.say(vec![b'x'; 200_000]);
        process.say("\n{\"id\":7,\"command\":\"stop\"}\n");
        assert!(matches!(process.wait_for(answer(7)), Report::Done { .. }));
        process.close_stdin();
        let (status, _, log) = process.wait();
        assert_eq!(status, Some(0), "{log}");
        assert!(log.contains("lines_refused=5"), "{log}");
        assert!(
            log.contains("unknown variant `fly`") && log.contains("longer than 65536"),
            "{log}"
        );
        assert!(!log.contains('\x1b'), "{log}");
    });
}

#[test]
fn a_port_that_cannot_be_opened_is_named_with_what_to_check() {
    let file = std::env::current_exe().unwrap();
    let file = file.to_str().unwrap();
    for (gyro, base, says) in [
        ("/dev/no-such-port", "none", ["gyro port /dev/no-such-port", "check the spelling"]),
        (
            "/dev/no-such-port",
            "serial:/dev/neither",
            ["gyro port /dev/no", "base port /dev/neither"],
        ),
        (file, "none", ["cannot open gyro port", "check that it is a serial port"]),
        ("/dev/null", "can:nocan7", ["cannot open gyro port /dev/null", "base port nocan7"]),
    ] {
        let (status, reports, log) = Process::start(&["--gyro", gyro, "--base", base]).wait();
        assert_eq!(status, Some(3), "{log}");
        assert!(reports.is_empty());
        assert!(says.iter().all(|words| log.contains(words)), "{log}");
    }
}

#[test]
fn bad_arguments_have_their_own_status() {
    for arguments in [&[][..], &["--gyro", "x", "--mode", "increment"], &["--gyro", "x:1"]] {
        let (status, reports, log) = Process::start(arguments).wait();
        assert_eq!((status, reports.len()), (Some(2), 0), "{log}");
        assert!(log.contains("error: "), "{log}");
    }
}

#[test]
fn a_port_that_vanishes_shows_as_silence_and_the_base_is_stopped() {
    in_time(|| {
        let (gyro, (base, requests)) = (gyro(b""), base(b""));
        let folder = tempfile::tempdir().unwrap();
        let (link, port) = linked(folder.path(), &gyro.port);
        let mut process = driving(&port, &serial(&base));
        std::fs::remove_file(link).unwrap();
        drop(gyro);
        assert_eq!(
            process.wait_for(answer(2)),
            Report::Aborted { id: 2, reason: AbortReason::GyroSilent }
        );
        process.wait_for(|report| {
            matches!(report, Report::Health(health) if health.causes.gyro_silent).then_some(())
        });
        process.close_stdin();
        let (status, _, log) = process.wait();
        assert_eq!(status, Some(0), "{log}");
        assert!(log.contains(&format!("gyro port {port} is gone")), "{log}");
        assert_eq!(requests.lock().unwrap().last(), Some(&Request::Stop));
    });
}

#[test]
fn a_port_that_comes_back_is_opened_again() {
    in_time(|| {
        let folder = tempfile::tempdir().unwrap();
        let first = gyro(b"");
        let (link, port) = linked(folder.path(), &first.port);
        let mut process = Process::start(&["--gyro", &port]);
        let heard = |report: &Report| {
            matches!(report, Report::State(state) if state.samples > 0).then_some(())
        };
        process.wait_for(heard);
        std::fs::remove_file(&link).unwrap();
        drop(first);
        process.wait_for(|report| {
            matches!(report, Report::Health(health) if health.causes.gyro_silent).then_some(())
        });
        let second = gyro(b"");
        std::os::unix::fs::symlink(&second.port, &link).unwrap();
        process.wait_for(|report| {
            matches!(report, Report::Health(health) if !health.causes.gyro_silent).then_some(())
        });
        process.close_stdin();
        let (status, _, log) = process.wait();
        assert_eq!(status, Some(0), "{log}");
        assert!(log.contains("is open again"), "{log}");
    });
}
