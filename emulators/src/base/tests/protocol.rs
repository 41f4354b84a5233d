//! Transmissions: reports, answers, time-outs and refusals.

use super::{base, motions, papers_base, replies, seconds, velocity};
use crate::base::{
    BaseEmulator, BaseParameters, MOTION_PERIOD_AT_REST, MOTION_PERIOD_IN_MOTION, Transport,
};
use wire::base::serial_link::{Host, HostEvent};
use wire::base::{PoseWriteResult, Reply, Request};
use wire::device::Transmit;
use wire::time::Timestamp;
use wire::units::{Angle, Length, Pose};

#[test]
fn silence_stops_the_base_and_is_reported() {
    let mut base = base(BaseParameters::default());
    base.request(Timestamp::ZERO, velocity(0.5, 0.0));
    let log = motions(replies(&mut base, Timestamp::ZERO, seconds(5.0)));
    // 0.25 m/s^2 for the time-out of 0.5 s, and back.
    let (stopped_at, last) =
        log.iter().find(|(_, motion)| motion.command_timed_out && !motion.moving).unwrap();
    assert_eq!(*stopped_at, seconds(1.0));
    assert!((last.displacement.m() - 0.0625).abs() < 1e-4);
    base.request(seconds(5.0), velocity(0.1, 0.0));
    assert!(!motions(replies(&mut base, seconds(5.0), seconds(5.0)))[0].1.command_timed_out);
    // A command to stand still has no time-out.
    base.request(seconds(5.0), velocity(0.0, 0.0));
    assert!(
        motions(replies(&mut base, seconds(5.0), seconds(9.0)))
            .iter()
            .all(|(_, m)| !m.command_timed_out)
    );
}

#[test]
fn a_pose_is_written_at_rest_only() {
    let mut base = base(papers_base());
    let pose =
        Pose { x: Length::from_m(1.0), y: Length::from_m(-2.0), heading: Angle::from_deg(10.14) };
    let write = |counter| Request::WritePose { pose, counter };
    let result = |base: &mut BaseEmulator, at| {
        let motion = motions(replies(base, at, at)).last().unwrap().1;
        (motion.pose_write, motion.pose_write_counter)
    };
    base.request(Timestamp::ZERO, write(1));
    assert_eq!(result(&mut base, Timestamp::ZERO), (PoseWriteResult::Accepted, 1));
    base.request(seconds(1.0), velocity(0.2, 0.0));
    base.request(seconds(1.1), write(2));
    assert_eq!(result(&mut base, seconds(1.1)), (PoseWriteResult::RefusedInMotion, 2));
    let written =
        replies(&mut base, seconds(1.1), seconds(5.0)).into_iter().rev().find_map(|(_, reply)| {
            match reply {
                Reply::Pose(pose) => Some(pose),
                Reply::Motion(_) => None,
            }
        });
    let (driven, heading) = (written.unwrap(), pose.heading);
    // The resolution of the written pose, and dead reckoning from there: 0.1 m forward before the time-out.
    assert!((driven.heading - heading).abs().deg() < 1e-9);
    let way = base.kinematics.state_at(seconds(5.0)).displacement;
    assert!(way > 0.05 && (driven.x.m() - 1.0 - way * heading.cos()).abs() < 1e-4);
    assert!((driven.y.m() + 2.0 - way * heading.sin()).abs() < 1e-4);
}

#[test]
fn headings_are_reported_in_steps() {
    let mut base = base(papers_base());
    base.request(Timestamp::ZERO, velocity(0.0, 7.0));
    for (_, motion) in motions(replies(&mut base, Timestamp::ZERO, seconds(1.5))) {
        let steps = motion.heading.deg() / 0.3;
        assert!((steps - steps.round()).abs() < 1e-6);
    }
}

#[test]
fn motion_comes_often_in_motion_seldom_at_rest_and_at_once_on_a_change() {
    let mut base = base(BaseParameters::default());
    let log = motions(replies(&mut base, Timestamp::ZERO, seconds(1.3)));
    assert_eq!(log.iter().map(|(at, _)| *at).collect::<Vec<_>>(), [0.0, 0.5, 1.0].map(seconds));
    assert_eq!(log[1].0 - log[0].0, MOTION_PERIOD_AT_REST);
    base.request(seconds(1.3), velocity(0.1, 0.0));
    let log = motions(replies(&mut base, seconds(1.3), seconds(5.0)));
    assert_eq!(log[0].0, seconds(1.3));
    assert!(log[0].1.moving);
    assert_eq!(log[1].0 - log[0].0, MOTION_PERIOD_IN_MOTION);
    // 0.5 s until it times out, 0.4 s to stop.
    let (stopped_at, _) = log.iter().find(|(_, motion)| !motion.moving).unwrap();
    assert_eq!(*stopped_at, seconds(1.3 + 0.5 + 0.4));
    let sequences: Vec<u8> = log.iter().map(|(_, motion)| motion.sequence).collect();
    assert!(sequences.windows(2).all(|pair| pair[1] == pair[0].wrapping_add(1)));
}

#[test]
fn an_emergency_stop_stops_hard_and_holds() {
    let mut base = base(BaseParameters::default());
    base.request(Timestamp::ZERO, velocity(0.1, 0.0));
    base.wake(seconds(0.4));
    while base.transmit().is_some() {}
    base.set_emergency_stop(seconds(0.4), true);
    base.request(seconds(0.5), velocity(0.1, 0.0));
    let log = motions(replies(&mut base, seconds(0.5), seconds(2.0)));
    assert!(log.iter().all(|(_, motion)| motion.emergency_stop));
    // 0.1 m/s at 0.5 m/s^2.
    assert_eq!(log.iter().find(|(_, motion)| !motion.moving).unwrap().0, seconds(0.6));
    base.set_emergency_stop(seconds(2.0), false);
    base.request(seconds(2.0), velocity(0.1, 0.0));
    assert!(motions(replies(&mut base, seconds(2.0), seconds(2.1))).last().unwrap().1.moving);
}

#[test]
fn the_serial_line_answers_writes_and_reads() {
    let mut base = BaseEmulator::new(papers_base(), Transport::Serial, 1, "base");
    assert_eq!(base.next_wakeup(), None);
    let mut host = Host::default();
    let mut exchange = |base: &mut BaseEmulator, now, request| {
        let line = host.start(&request).unwrap();
        for byte in line.as_slice() {
            base.receive_bytes(now, &[*byte]);
        }
        let mut events = Vec::new();
        while let Some(Transmit::Bytes(bytes)) = base.transmit() {
            host.feed(bytes.as_slice(), |event| events.push(event));
        }
        events
    };
    let written = exchange(&mut base, Timestamp::ZERO, velocity(0.2, 0.0));
    assert!(matches!(written[..], [HostEvent::Written(_)]), "{written:?}");
    let read = exchange(&mut base, seconds(0.4), Request::ReadMotion);
    let [HostEvent::Reply(Reply::Motion(motion))] = read[..] else { panic!("{read:?}") };
    assert!(motion.moving && (motion.displacement.m() - 0.02).abs() < 1e-4);
    let read = exchange(&mut base, seconds(0.4), Request::ReadPose);
    assert!(matches!(read[..], [HostEvent::Reply(Reply::Pose(_))]), "{read:?}");
}
