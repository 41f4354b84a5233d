//! SocketCAN.

use crate::link::{Link, ip};
use crate::{NOW, frame, heard, opened, run};
use ports::{FrameEvent, FramePort, PortError, PortLost, PortSpec};
use socketcan::{
    CanAnyFrame, CanErrorFrame, CanFdFrame, CanFdSocket, EmbeddedFrame as _, Socket as _,
};
use wire::can::{BitRates, CanFrame, FdFlags, StandardId};
use wire::can_error::{BusState, CanErrorEvent};

#[test]
fn frames_cross_both_ways_and_own_ones_are_not_heard() {
    run(async {
        let Some(link) = Link::make("hilframes").await else { return };
        let (mut here, mut there) = (opened(link.0).await, opened(link.0).await);
        assert_eq!(here.far_path(), Some(link.0));
        for number in 0..20 {
            here.send(NOW, &frame(number));
            assert_eq!(heard(&mut there).await, frame(number));
            there.send(NOW, &frame(number + 100));
            assert_eq!(heard(&mut here).await, frame(number + 100));
        }
        let counters = here.counters();
        assert_eq!((counters.frames_in, counters.frames_out), (20, 20));
        assert!(counters.all_crossed());
    });
}

#[test]
fn error_frames_are_events_of_the_bus() {
    run(async {
        let Some(link) = Link::make("hilerrors").await else { return };
        let (mut here, mut there) = (opened(link.0).await, opened(link.0).await);
        let driver = CanFdSocket::open(link.0).unwrap();
        let report = |class: u32, data: [u8; 8]| {
            let frame = CanErrorFrame::new_error(0x2000_0000 | class, &data).unwrap();
            driver.write_frame(&frame).unwrap();
        };
        for (class, data, state) in [
            (0x204, [0, 0x08, 0, 0, 0, 0, 96, 0], BusState::Warning),
            (0x204, [0, 0x20, 0, 0, 0, 0, 128, 0], BusState::Passive),
            (0x240, [0, 0, 0, 0, 0, 0, 255, 0], BusState::BusOff),
            (0x204, [0, 0x40, 0, 0, 0, 0, 0, 0], BusState::Active),
        ] {
            report(class, data);
            let Ok(FrameEvent::Bus(event)) = there.receive().await else { panic!("{state}") };
            assert_eq!(event.bus_state(), Some(state));
        }
        let lost = CanErrorEvent { lost_arbitration: Some(7), ..CanErrorEvent::default() };
        report(0x002, [7, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(there.receive().await, Ok(FrameEvent::Bus(lost)));
        // Simulated errors do no harm: frames still cross.
        here.send(NOW, &frame(1));
        assert_eq!(heard(&mut there).await, frame(1));
        assert_eq!(there.counters().error_frames, 5);
    });
}

#[test]
fn fd_frames_cross_an_interface_that_has_them() {
    run(async {
        let Some(link) = Link::make("hilfd").await else { return };
        let mut here = opened(link.0).await;
        let there = CanFdSocket::open(link.0).unwrap();
        let id = StandardId::new(0x123).unwrap();
        let fd =
            |length, bits| CanFrame::fd(id, FdFlags::from_bits(bits), &vec![9; length]).unwrap();
        for length in [64, 8, 12, 3] {
            there.write_frame(&CanFdFrame::new(id, &vec![9; length]).unwrap()).unwrap();
            assert_eq!(heard(&mut here).await, fd(length, 0));
        }
        let counters = here.counters();
        assert_eq!((counters.fd_frames, counters.unsupported_frames), (4, 0));
        here.send(NOW, &fd(48, 1));
        let CanAnyFrame::Fd(sent) = there.read_frame().unwrap() else { panic!("no FD frame") };
        assert_eq!((sent.data(), sent.is_brs()), (&[9; 48][..], true));
        assert_eq!(here.counters().frames_out, 1);
    });
}

#[test]
fn an_interface_that_goes_down_is_waited_for() {
    run(async {
        let Some(link) = Link::make("hildown").await else { return };
        let (mut here, mut there) = (opened(link.0).await, opened(link.0).await);
        link.set("down").await.unwrap();
        assert_eq!(here.receive().await, Ok(FrameEvent::Down));
        assert_eq!(there.receive().await, Ok(FrameEvent::Down));
        here.send(NOW, &frame(1));
        assert_eq!(here.counters().overrun_frames, 1);
        let wait = tokio::time::timeout(std::time::Duration::from_millis(200), here.receive());
        assert!(wait.await.is_err(), "it is down");

        link.set("up").await.unwrap();
        assert_eq!(here.receive().await, Ok(FrameEvent::Up));
        // Reported before the frame, although the frame arrived first.
        here.send(NOW, &frame(2));
        assert_eq!(there.receive().await, Ok(FrameEvent::Up));
        assert_eq!(heard(&mut there).await, frame(2));
        assert_eq!((here.counters().returns, here.counters().frames_out), (1, 1));
    });
}

#[test]
fn an_interface_that_is_deleted_is_lost_and_comes_back() {
    run(async {
        let Some(link) = Link::make("hildeleted").await else { return };
        let mut here = opened(link.0).await;
        link.delete().await.unwrap();
        let lost = loop {
            match here.receive().await {
                // Deleting sets it down first.
                Ok(FrameEvent::Down) => {}
                Ok(other) => panic!("{other:?}"),
                Err(lost) => break lost,
            }
        };
        assert_eq!((lost, here.receive().await), (PortLost::Deleted, Err(PortLost::Deleted)));
        let (back, added) = tokio::join!(here.reopen(), link.add());
        assert!(back.is_ok() && added.is_ok(), "{back:?} {added:?}");
        let mut there = opened(link.0).await;
        there.send(NOW, &frame(3));
        assert_eq!(heard(&mut here).await, frame(3));
        assert_eq!(here.counters().returns, 1);
    });
}

#[test]
fn frames_beyond_the_receive_buffer_are_counted() {
    /// More than the buffer holds; the port enlarges it as far as the machine allows.
    const BURST: u32 = 40_000;
    run(async {
        let Some(link) = Link::make("hilburst").await else { return };
        let (mut here, mut there) = (opened(link.0).await, opened(link.0).await);
        for number in 0..BURST {
            here.send(NOW, &frame(number));
        }
        assert_eq!(here.counters().frames_out, u64::from(BURST));
        // Known at once, not only with the next frame.
        assert!(there.counters().receive_dropped_frames > 0, "{:?}", there.counters());
        // Each that is not heard is counted, also where the kernel's queue before the socket was full for a moment: on
        // a busy machine a few are dropped there, between others that are kept.
        let (mut kept, mut next) = (0, 0);
        while kept + there.counters().receive_dropped_frames < u64::from(BURST) {
            let number = u32::from_be_bytes(heard(&mut there).await.data().try_into().unwrap());
            assert!(number >= next, "{number} after {next}");
            (kept, next) = (kept + 1, number + 1);
        }
        here.send(NOW, &frame(BURST));
        assert_eq!(heard(&mut there).await, frame(BURST));
        let counters = there.counters();
        let accounted = counters.frames_in + counters.receive_dropped_frames;
        assert_eq!((counters.frames_in, accounted), (kept + 1, u64::from(BURST) + 1));
        assert!(!counters.all_crossed());
    });
}

#[test]
fn an_interface_that_cannot_be_opened_is_told_why() {
    run(async {
        let Some(link) = Link::make("hilclosed").await else { return };
        link.set("down").await.unwrap();
        let open = async |interface: &str| {
            let spec = PortSpec::Can { interface: interface.to_owned() };
            FramePort::open(&spec, BitRates::USUAL).await.unwrap_err()
        };
        let error = open(link.0).await;
        assert!(matches!(error, PortError::InterfaceDown { .. }), "{error}");
        ip(&["link", "set", "lo", "up"]).await.unwrap();
        for interface in ["hilmissing", "lo"] {
            let error = open(interface).await;
            assert!(matches!(error, PortError::NoInterface { .. }), "{error}");
        }
    });
}
