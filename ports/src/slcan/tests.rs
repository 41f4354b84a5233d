//! Both ends of an adapter's line, on one pty.

use super::{Lines, SlcanAdapter, SlcanHost};
use crate::error::{PortError, PortLost};
use crate::pty::Pty;
use crate::spec::{PortSpec, SerialSpec};
use crate::{Counters, FrameEvent};
use std::future::Future;
use std::time::Duration;
use wire::can::{CanFrame, ExtendedId, FdFlags, StandardId};
use wire::can_error::BusState;
use wire::slcan::BitRate;
use wire::time::Timestamp;

const NOW: Timestamp = Timestamp::ZERO;

fn run<T>(test: impl Future<Output = T>) -> T {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        tokio::time::timeout(Duration::from_secs(20), test).await.expect("the test ends")
    })
}

fn serial(path: &str) -> SerialSpec {
    match format!("slcan:{path}").parse().unwrap() {
        PortSpec::Slcan { serial, .. } => serial,
        other => panic!("{other}"),
    }
}

/// An adapter with an open bus, and its user.
async fn pair() -> (SlcanAdapter, SlcanHost) {
    let mut adapter = SlcanAdapter::open(None).unwrap();
    let spec = serial(adapter.far_path());
    let host = tokio::select! {
        host = SlcanHost::open(&spec, BitRate::Kbit250) => host.unwrap(),
        // Reported before the user knows that it may continue.
        event = async { let up = adapter.receive().await; assert_eq!(up, Ok(FrameEvent::Up)); adapter.receive().await } => panic!("{event:?}"),
    };
    (adapter, host)
}

fn frame(number: u32) -> CanFrame {
    CanFrame::new(ExtendedId::new(number).unwrap(), &number.to_be_bytes()).unwrap()
}

#[test]
fn frames_cross_both_ways() {
    run(async {
        let (mut adapter, mut host) = pair().await;
        let short = CanFrame::new(StandardId::new(0x101).unwrap(), b"").unwrap();
        let remote = embedded_remote();
        for frame in [frame(0x1234_5678), short, remote] {
            host.send(&frame);
            assert_eq!(adapter.receive().await, Ok(FrameEvent::Frame(frame)));
            adapter.send(NOW, &frame);
            assert_eq!(host.receive().await, Ok(FrameEvent::Frame(frame)));
        }
        let (here, there) = (host.counters(), adapter.counters());
        assert_eq!((here.frames_out, here.frames_in), (3, 3));
        assert_eq!((there.frames_out, there.frames_in), (3, 3));
        assert!(here.all_crossed() && there.overrun_frames == 0, "{here:?} {there:?}");
    });
}

/// The protocol has no such line: anything written would be another frame.
#[test]
fn an_fd_frame_is_lost_and_counted() {
    run(async {
        let (mut adapter, mut host) = pair().await;
        let fd = CanFrame::fd(StandardId::ZERO, FdFlags::default(), &[1; 12]).unwrap();
        host.send(&fd);
        host.send(&frame(1));
        assert_eq!(adapter.receive().await, Ok(FrameEvent::Frame(frame(1))));
        adapter.send(NOW, &fd);
        adapter.send(NOW, &frame(2));
        assert_eq!(host.receive().await, Ok(FrameEvent::Frame(frame(2))));
        for counters in [host.counters(), adapter.counters()] {
            assert_eq!((counters.frames_out, counters.overrun_frames), (1, 1), "{counters:?}");
        }
    });
}

fn embedded_remote() -> CanFrame {
    use socketcan::EmbeddedFrame as _;
    CanFrame::new_remote(StandardId::new(0x7ff).unwrap(), 3).unwrap()
}

#[test]
fn the_state_of_the_bus_is_told() {
    run(async {
        let mut far = Pty::open().unwrap();
        let mut host = SlcanHost::open(&serial(far.path()), BitRate::Kbit500).await.unwrap();
        for (line, state) in [
            (b"sw000096\r", BusState::Warning),
            (b"sp000128\r", BusState::Passive),
            (b"sb000256\r", BusState::BusOff),
            (b"sa000000\r", BusState::Active),
        ] {
            far.write(line);
            let Ok(FrameEvent::Bus(heard)) = host.receive().await else { panic!("{state}") };
            assert_eq!(heard.bus_state(), Some(state));
        }
        far.write(b"e1a\r");
        let Ok(FrameEvent::Bus(heard)) = host.receive().await else { panic!("no event") };
        assert!(heard.no_acknowledgement);
        assert_eq!(host.counters().error_frames, 5);
    });
}

#[test]
fn a_bus_that_nobody_has_opened_hears_nothing() {
    run(async {
        let mut adapter = SlcanAdapter::open(None).unwrap();
        adapter.send(NOW, &frame(1));
        assert_eq!(adapter.counters().overrun_frames, 1);
        assert_eq!(adapter.counters().bytes_out, 0);
    });
}

#[test]
fn who_leaves_closes_the_bus() {
    run(async {
        let (mut adapter, host) = pair().await;
        drop(host);
        assert_eq!(adapter.receive().await, Ok(FrameEvent::Down));
        let spec = serial(adapter.far_path());
        let (host, heard) = tokio::join!(SlcanHost::open(&spec, BitRate::Mbit1), adapter.receive());
        assert_eq!((host.is_ok(), heard), (true, Ok(FrameEvent::Up)));
    });
}

/// More than a pty holds.
const BURST: u32 = 3_000;
/// The line is quiet after this time without input.
const QUIET: Duration = Duration::from_millis(20);

/// The frames that arrive when `send` is called with more of them than the line holds, and then with one at a time
/// until the line has recovered. `receive` waits for the next, and `counters` are the sender's.
async fn burst<P, Q>(
    (sender, receiver): (&mut P, &mut Q),
    send: impl Fn(&mut P, &CanFrame),
    counters: impl Fn(&P) -> Counters,
    receive: impl AsyncFn(&mut Q) -> Result<FrameEvent, PortLost>,
) {
    let mut numbers: Vec<u32> = Vec::new();
    let mut offered = 0;
    while offered < BURST {
        send(sender, &frame(offered));
        offered += 1;
    }
    loop {
        match tokio::time::timeout(QUIET, receive(receiver)).await {
            Ok(Ok(FrameEvent::Frame(frame))) => {
                numbers.push(u32::from_be_bytes(frame.data().try_into().unwrap()));
            }
            Ok(other) => panic!("{other:?}"),
            Err(_) => {
                let all = numbers.len() as u64 == counters(sender).frames_out;
                if all && numbers.last().is_some_and(|last| *last >= BURST) {
                    break;
                }
                send(sender, &frame(offered));
                offered += 1;
            }
        }
    }
    assert!(numbers.is_sorted_by(|a, b| a < b), "{numbers:?}");
    let counters = counters(sender);
    assert_eq!(counters.frames_out + counters.overrun_frames, u64::from(offered));
    assert!(counters.overrun_frames > 0, "{counters:?}");
}

#[test]
fn a_burst_at_an_adapter_that_does_not_read_is_counted_and_tears_no_frame() {
    run(async {
        let (mut adapter, mut host) = pair().await;
        let (send, receive) = (SlcanHost::send, SlcanAdapter::receive);
        burst((&mut host, &mut adapter), send, SlcanHost::counters, receive).await;
    });
}

#[test]
fn a_burst_at_a_user_who_does_not_read_is_counted_and_tears_no_frame() {
    run(async {
        let (mut adapter, mut host) = pair().await;
        let send = |adapter: &mut SlcanAdapter, frame: &CanFrame| adapter.send(NOW, frame);
        burst((&mut adapter, &mut host), send, SlcanAdapter::counters, SlcanHost::receive).await;
    });
}

#[test]
fn an_adapter_that_refuses_is_named() {
    run(async {
        let mut far = Pty::open().unwrap();
        let spec = serial(far.path());
        let refusing = async {
            let mut buffer = [0; 64];
            loop {
                let count = far.read(&mut buffer).await.unwrap();
                if buffer[..count].contains(&b'S') {
                    far.write(b"\x07");
                }
            }
        };
        let error = tokio::select! {
            host = SlcanHost::open(&spec, BitRate::Kbit800) => host.unwrap_err(),
            () = refusing => unreachable!(),
        };
        assert!(matches!(error, PortError::AdapterRefused { .. }), "{error}");
        assert!(error.to_string().contains("take the bitrate"), "{error}");
    });
}

/// On a busy machine, the refusal to close a closed bus came when the bit rate had been sent.
#[test]
fn an_adapter_that_is_slow_to_answer_is_opened() {
    run(async {
        let mut far = Pty::open().unwrap();
        let spec = serial(far.path());
        let slow = async {
            let mut buffer = [0; 64];
            let mut is_late = true;
            loop {
                let count = far.read(&mut buffer).await.unwrap();
                for byte in &buffer[..count] {
                    match byte {
                        b'C' if is_late => {}
                        b'S' if std::mem::take(&mut is_late) => _ = far.write(b"\x07\r"),
                        b'C' => _ = far.write(b"\x07"),
                        b'S' | b'O' => _ = far.write(b"\r"),
                        _ => {}
                    }
                }
            }
        };
        let host = tokio::select! {
            host = SlcanHost::open(&spec, BitRate::Kbit500) => host,
            () = slow => unreachable!(),
        };
        assert!(host.is_ok(), "{host:?}");
    });
}

#[test]
fn an_adapter_that_acknowledges_nothing_is_used_all_the_same() {
    run(async {
        let mut far = Pty::open().unwrap();
        let mut host = SlcanHost::open(&serial(far.path()), BitRate::Kbit500).await.unwrap();
        let mut buffer = [0; 64];
        let count = far.try_read(&mut buffer).unwrap();
        assert_eq!(buffer[..count].escape_ascii().to_string(), r"\r\r\rC\rS6\rO\r");
        far.write(b"t10120102\rrubbish\r");
        let frame = CanFrame::new(StandardId::new(0x101).unwrap(), &[1, 2]).unwrap();
        assert_eq!(host.receive().await, Ok(FrameEvent::Frame(frame)));
        drop(far);
        assert_eq!(host.receive().await, Err(PortLost::HungUp));
        assert_eq!(host.counters().malformed_lines, 1);
    });
}

#[test]
fn an_adapter_that_is_plugged_in_again_is_opened_again() {
    run(async {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ttyACM0");
        let mut adapter = SlcanAdapter::open(Some(&path)).unwrap();
        let spec = serial(path.to_str().unwrap());
        let (host, up) = tokio::join!(SlcanHost::open(&spec, BitRate::Kbit125), adapter.receive());
        let mut host = host.unwrap();
        assert_eq!(up, Ok(FrameEvent::Up));

        drop(adapter);
        assert_eq!(host.receive().await, Err(PortLost::HungUp));
        host.send(&frame(1));
        let mut adapter = SlcanAdapter::open(Some(&path)).unwrap();
        let (back, up) = tokio::join!(host.reopen(), adapter.receive());
        assert!(back.is_ok() && up == Ok(FrameEvent::Up), "{back:?} {up:?}");
        host.send(&frame(2));
        assert_eq!(adapter.receive().await, Ok(FrameEvent::Frame(frame(2))));
        let counters = host.counters();
        assert_eq!((counters.returns, counters.overrun_frames, counters.frames_out), (1, 1, 1));
    });
}

/// Found by a user: the loop of a run looks at its ports a thousand times a second, and each look began anew, so that an
/// adapter was never open again.
#[test]
fn an_adapter_is_opened_again_however_often_the_wait_is_called_off() {
    run(async {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ttyACM0");
        let mut adapter = SlcanAdapter::open(Some(&path)).unwrap();
        let spec = serial(path.to_str().unwrap());
        let (host, up) = tokio::join!(SlcanHost::open(&spec, BitRate::Kbit125), adapter.receive());
        let mut host = host.unwrap();
        assert_eq!(up, Ok(FrameEvent::Up));
        drop(adapter);
        assert_eq!(host.receive().await, Err(PortLost::HungUp));

        let mut adapter = SlcanAdapter::open(Some(&path)).unwrap();
        let looks = async {
            let mut looks = 0;
            while tokio::time::timeout(Duration::from_millis(1), host.reopen()).await.is_err() {
                // What is sent before the bus is open must not get between the commands.
                host.send(&frame(1));
                looks += 1;
            }
            looks
        };
        let (looks, up) = tokio::join!(looks, adapter.receive());
        assert_eq!(up, Ok(FrameEvent::Up));
        host.send(&frame(2));
        assert_eq!(adapter.receive().await, Ok(FrameEvent::Frame(frame(2))));
        let counters = host.counters();
        assert_eq!((counters.returns, counters.frames_out), (1, 1), "{counters:?}");
        assert_eq!((looks > 1, counters.overrun_frames), (true, looks));
    });
}

#[test]
fn the_rest_of_a_line_that_was_torn_goes_before_the_next() {
    let (mut lines, mut crossed) = (Lines::default(), Vec::new());
    let mut room = 3;
    let mut send = |lines: &mut Lines, more: usize, crossed: &mut Vec<u8>, line: &[u8]| {
        room += more;
        lines.send(line, |bytes| {
            let taken = bytes.len().min(room);
            room -= taken;
            crossed.extend_from_slice(&bytes[..taken]);
            taken
        })
    };
    assert!(send(&mut lines, 0, &mut crossed, b"t1000\r"));
    assert!(!send(&mut lines, 0, &mut crossed, b"t2000\r"));
    assert!(!send(&mut lines, 1, &mut crossed, b"t3000\r"));
    assert!(send(&mut lines, 6, &mut crossed, b"t4000\r"));
    assert!(send(&mut lines, 8, &mut crossed, b"t5000\r"));
    assert_eq!(crossed, b"t1000\rt4000\rt5000\r");
}
