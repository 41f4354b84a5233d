//! Sockets and a pty stand in for running controllers.

use super::{AttachedDevice, AttachedEvent, LINE_SETTINGS};
use crate::process::ReportedLine;
use controller::mission::{Command, Mission};
use plan::bench_file::AttachPlace;
use ports::{ByteEvent, BytePort};
use std::time::Duration;
use tokio::io::{AsyncBufReadExt as _, AsyncReadExt as _, AsyncWriteExt as _, BufReader};
use tokio::net::{TcpListener, UnixListener};

const LIMIT: Duration = Duration::from_secs(20);
/// More than fit into a pty, but no more than may wait.
const MISSIONS: u32 = 60;
const REPORT: &[u8] = br#"{"at_ns":5,"report":{"refused":{"id":1,"reason":"busy"}}}"#;

fn run<T>(test: impl Future<Output = T>) -> T {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async { tokio::time::timeout(LIMIT, test).await.expect("the test ends") })
}

fn stop(id: u32) -> Mission {
    Mission { id, command: Command::Stop }
}

fn place(text: &str) -> AttachPlace {
    text.parse().unwrap()
}

#[test]
fn one_that_comes_later_is_found_and_its_end_is_told() {
    run(async {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("missions.sock");
        let mut device =
            AttachedDevice::begin(&place(&format!("unix:{}", path.display()))).unwrap();
        assert!(matches!(device.next_event().await, AttachedEvent::NotThere(_)));
        let listener = UnixListener::bind(&path).unwrap();
        let (mut there, _) = listener.accept().await.unwrap();
        while device.next_event().await != AttachedEvent::Connected {}
        assert!(device.send(&stop(7)));
        let mut line = String::new();
        BufReader::new(&mut there).read_line(&mut line).await.unwrap();
        assert_eq!(line, "{\"id\":7,\"command\":\"stop\"}\n");
        there.write_all(&[REPORT, b"\r\n\nnonsense\n", REPORT].concat()).await.unwrap();
        assert!(matches!(device.next_event().await, AttachedEvent::Line(ReportedLine::Report(_))));
        let bad = device.next_event().await;
        assert!(matches!(bad, AttachedEvent::Line(ReportedLine::Bad { number: 3, .. })), "{bad:?}");
        drop(there);
        let lost = device.next_event().await;
        assert_eq!(lost, AttachedEvent::Ended("it closed the connection".to_owned()));
    });
}

#[test]
fn what_was_accepted_leaves_before_the_end() {
    run(async {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let mut device = AttachedDevice::begin(&place(&format!("tcp:{address}"))).unwrap();
        let (mut there, _) = listener.accept().await.unwrap();
        assert_eq!(device.next_event().await, AttachedEvent::Connected);
        // It keeps sending, and its reports are no longer fetched.
        there.write_all(&[REPORT, b"\n"].concat()).await.unwrap();
        assert!((0..10).all(|id| device.send(&stop(id))));
        device.end().await;
        let mut said = String::new();
        there.read_to_string(&mut said).await.unwrap();
        assert_eq!(said.lines().count(), 10, "{said}");
    });
}

#[test]
fn one_that_takes_nothing_costs_missions_and_no_time() {
    run(async {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let mut device = AttachedDevice::begin(&place(&format!("tcp:{address}"))).unwrap();
        let (_there, _) = listener.accept().await.unwrap();
        assert_eq!(device.next_event().await, AttachedEvent::Connected);
        let sent = (0..100_000).filter(|id| device.send(&stop(*id))).count();
        assert!(sent < 100_000);
    });
}

#[test]
fn a_line_carries_missions_longer_than_it_has_room_for() {
    run(async {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("missions.pty");
        let mut device = AttachedDevice::begin(&place(&format!("pty:{}", link.display()))).unwrap();
        assert_eq!(device.far_path(), Some(link.to_str().unwrap()));
        assert_eq!(device.next_event().await, AttachedEvent::Connected);
        let long = Command::SetCalibration(controller::calibration::Calibration::default());
        let all = (0..MISSIONS).all(|id| device.send(&Mission { id, command: long.clone() }));
        assert!(all);
        let there = format!("serial:{}", link.display()).parse().unwrap();
        let mut there = BytePort::open(&there, LINE_SETTINGS).unwrap();
        let mut heard = Vec::new();
        while heard.iter().filter(|byte| **byte == b'\n').count() < MISSIONS as usize {
            let Ok(ByteEvent::Bytes(packet)) = there.receive().await else { panic!("bytes") };
            heard.extend_from_slice(packet.as_slice());
        }
        let lines = std::str::from_utf8(&heard).unwrap().lines();
        let missions = lines.map(|line| serde_json::from_str::<Mission>(line).unwrap().id);
        assert!(missions.eq(0..MISSIONS));
        there.send(&[REPORT, b"\n"].concat());
        assert!(matches!(device.next_event().await, AttachedEvent::Line(ReportedLine::Report(_))));
    });
}

#[test]
fn a_line_that_is_not_there_is_named() {
    run(async {
        let error = AttachedDevice::begin(&place("/dev/there-is-no-such-port")).unwrap_err();
        assert!(error.to_string().contains("there-is-no-such-port"), "{error}");
    });
}
