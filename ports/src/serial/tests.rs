//! Serial ports on ptys; a pty has no framing errors and no breaks, which `marks` tests.

use super::{SerialEvent, SerialPort};
use crate::error::{PortError, PortLost};
use crate::pty::Pty;
use crate::spec::{PortSpec, SerialSpec};
use miette::Diagnostic as _;
use rustix::fs::{Mode, OFlags};
use rustix::termios::{ControlModes, InputModes, tcgetattr};
use std::future::Future;
use std::os::unix::fs::symlink;
use std::time::Duration;
use wire::serial::SerialSettings;

const USUAL: SerialSettings = SerialSettings::new_8n1(9_600);

fn run<T>(test: impl Future<Output = T>) -> T {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        tokio::time::timeout(Duration::from_secs(20), test).await.expect("the test ends")
    })
}

fn spec(text: &str) -> SerialSpec {
    match text.parse().unwrap() {
        PortSpec::Serial(spec) => spec,
        other => panic!("{other}"),
    }
}

fn opened(path: &str) -> SerialPort {
    SerialPort::open(&spec(path), USUAL).unwrap()
}

async fn heard(port: &mut SerialPort, count: usize) -> Vec<u8> {
    let mut heard = Vec::new();
    while heard.len() < count {
        match port.receive().await.unwrap() {
            SerialEvent::Bytes(packet) => heard.extend_from_slice(packet.as_slice()),
            SerialEvent::Break => panic!("a break among {heard:?}"),
        }
    }
    heard
}

#[test]
fn every_byte_crosses_unchanged_both_ways() {
    run(async {
        let all: Vec<u8> = (0..=255).chain([255, 0, 0, 255, 255, 0]).collect();
        for options in ["", "?exclusive=no"] {
            let mut far = Pty::open().unwrap();
            let mut port = opened(&format!("{}{options}", far.path()));
            far.write(&all);
            assert_eq!(heard(&mut port, all.len()).await, all);
            assert_eq!(port.send(&all), all.len());
            let (mut crossed, mut buffer) = (Vec::new(), [0; 512]);
            while crossed.len() < all.len() {
                let count = far.read(&mut buffer).await.unwrap();
                crossed.extend_from_slice(&buffer[..count]);
            }
            assert_eq!(crossed, all);
            let counters = port.counters();
            assert_eq!(counters.bytes_out, all.len() as u64);
            assert_eq!((counters.line_errors, counters.breaks), (0, 0));
            assert!(counters.all_crossed());
        }
    });
}

#[test]
fn settings_reach_the_terminal() {
    run(async {
        let far = Pty::open().unwrap();
        let text = format!("{}?baud=57600&stop=2&flow=hardware&exclusive=no", far.path());
        let port = opened(&text);
        assert_eq!((port.settings().baud, far.baud().unwrap()), (57_600, 57_600));
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK;
        let terminal = rustix::fs::open(far.path(), flags, Mode::empty()).unwrap();
        let modes = tcgetattr(&terminal).unwrap().control_modes;
        assert!(modes.contains(ControlModes::CSTOPB | ControlModes::CRTSCTS), "{modes:?}");
        drop(port);

        let before = tcgetattr(&terminal).unwrap().input_modes;
        let port = opened(&format!("{}?flow=software", far.path()));
        let modes = tcgetattr(&terminal).unwrap().input_modes;
        assert!(modes.contains(InputModes::IXON | InputModes::PARMRK), "{modes:?}");
        assert_eq!(far.baud().unwrap(), 9_600);
        // Found by a user: the next program read each 0xFF twice.
        drop(port);
        let after = tcgetattr(&terminal).unwrap().input_modes;
        let marks = InputModes::PARMRK | InputModes::INPCK;
        assert_eq!(after & marks, before & marks);
    });
}

#[test]
fn what_nobody_reads_is_counted_and_never_waited_for() {
    run(async {
        let far = Pty::open().unwrap();
        let mut port = opened(far.path());
        let taken: usize = (0..1_000).map(|_| port.send(&[7; 100])).sum();
        let counters = port.counters();
        assert_eq!(counters.bytes_out, taken as u64);
        assert_eq!(counters.overrun_bytes, 100_000 - taken as u64);
        assert!(taken < 100_000 && !counters.all_crossed());
    });
}

#[test]
fn a_wait_may_be_called_off() {
    run(async {
        let mut far = Pty::open().unwrap();
        let mut port = opened(far.path());
        assert!(tokio::time::timeout(Duration::from_millis(5), port.receive()).await.is_err());
        far.write(b"x");
        assert_eq!(heard(&mut port, 1).await, b"x");
    });
}

#[test]
fn a_port_that_is_unplugged_is_lost_and_comes_back() {
    run(async {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ttyUSB0");
        let mut far = Pty::open().unwrap();
        symlink(far.path(), &path).unwrap();
        let mut port = opened(path.to_str().unwrap());
        far.write(b"before");
        assert_eq!(heard(&mut port, 6).await, b"before");

        drop(far);
        std::fs::remove_file(&path).unwrap();
        assert_eq!(port.receive().await, Err(PortLost::HungUp));
        assert_eq!(port.receive().await, Err(PortLost::HungUp));
        assert_eq!(port.send(b"nowhere"), 0);

        // Cancelled repeatedly, it still finds the port once it exists.
        let mut plugged_in = None;
        for tries in 0.. {
            if let Ok(back) = tokio::time::timeout(Duration::from_millis(20), port.reopen()).await {
                back.unwrap();
                break;
            }
            if tries == 3 {
                let far = Pty::open().unwrap();
                symlink(far.path(), &path).unwrap();
                plugged_in = Some(far);
            }
        }
        let mut far = plugged_in.expect("it was not there before");
        far.write(b"after");
        assert_eq!(heard(&mut port, 5).await, b"after");
        let counters = port.counters();
        assert_eq!((counters.returns, counters.overrun_bytes), (1, 7));
    });
}

#[test]
fn a_port_that_does_not_open_is_told_why() {
    run(async {
        let far = Pty::open().unwrap();
        let _first = opened(far.path());
        let folder = tempfile::tempdir().unwrap();
        let (missing, file) = (folder.path().join("ttyUSB7"), folder.path().join("file"));
        std::fs::write(&file, "").unwrap();
        let mut said = String::new();
        for path in [far.path(), missing.to_str().unwrap(), file.to_str().unwrap()] {
            let error = SerialPort::open(&spec(path), USUAL).unwrap_err();
            let help = error.help().map(|help| help.to_string()).unwrap_or_default();
            said += &format!("{error}\n  {help}\n").replace(path, "PORT");
        }
        insta::assert_snapshot!(said);
    });
}

#[test]
fn who_listens_beside_another_must_be_let() {
    run(async {
        let far = Pty::open().unwrap();
        let path = format!("{}?exclusive=no", far.path());
        let (first, _second) = (opened(&path), opened(&path));
        let error = SerialPort::open(&spec(far.path()), USUAL).unwrap_err();
        assert!(matches!(error, PortError::Busy { .. }), "{error}");
        drop(first);
    });
}
