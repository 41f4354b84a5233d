use super::{
    BaseEmulator, BaseOutput, BaseParameters, MOTION_PERIOD_AT_REST, MOTION_PERIOD_IN_MOTION,
    Transport,
};
use proptest::prelude::*;
use wire::base::serial_link::{Host, HostEvent};
use wire::base::{Motion, PoseWriteResult, Reply, Request, can_link};
use wire::time::{Span, Timestamp};
use wire::units::{Acceleration, Angle, AngularAcceleration, AngularRate, Length, Pose, Speed};

fn seconds(seconds: f64) -> Timestamp {
    Timestamp::from_secs_f64(seconds)
}

fn velocity(m_per_s: f64, deg_per_s: f64) -> Request {
    Request::SetVelocity {
        drive: Speed::from_m_per_s(m_per_s),
        steer: AngularRate::from_deg_per_s(deg_per_s),
    }
}

fn base(parameters: BaseParameters) -> BaseEmulator {
    BaseEmulator::new(parameters, Transport::Can, 1, "base")
}

fn papers_base() -> BaseParameters {
    BaseParameters {
        turn_scale_error: 0.011,
        leakage_deg_per_m: 0.125,
        heading_step_deg: 0.3,
        ..Default::default()
    }
}

/// Everything sent at `from`, when a request may have come, and up to `until`.
fn replies(base: &mut BaseEmulator, from: Timestamp, until: Timestamp) -> Vec<(Timestamp, Reply)> {
    let mut replies = Vec::new();
    let mut now = from;
    loop {
        while let Some(BaseOutput::Frame(frame)) = base.transmit() {
            replies.push((now, can_link::parse_reply(&frame).unwrap()));
        }
        match base.next_wakeup() {
            Some(at) if at <= until => now = at,
            _ => return replies,
        }
        base.wake(now);
    }
}

fn motions(replies: Vec<(Timestamp, Reply)>) -> Vec<(Timestamp, Motion)> {
    let motion = |(at, reply)| match reply {
        Reply::Motion(motion) => Some((at, motion)),
        Reply::Pose(_) => None,
    };
    replies.into_iter().filter_map(motion).collect()
}

/// The paper's lap, closed by odometry: a 4 x 4 m square at 0.4 m/s and 30 deg/s, 64 s. Returns what
/// the odometer and the turret truly turned, in degrees.
fn lap(base: &mut BaseEmulator, direction: f64) -> (f64, f64) {
    let mut now = Timestamp::ZERO;
    base.request(
        now,
        Request::SetAcceleration {
            drive: Acceleration::from_m_per_s2(0.4),
            steer: AngularAcceleration::from_deg_per_s2(15.0),
        },
    );
    for _ in 0..4 {
        for (m_per_s, deg_per_s, command_s, ramp_s) in
            [(0.4, 0.0, 10.0, 1.0), (0.0, direction * 30.0, 3.0, 2.0)]
        {
            base.request(now, velocity(m_per_s, deg_per_s));
            now += Span::from_secs_f64(command_s);
            base.request(now, velocity(0.0, 0.0));
            now += Span::from_secs_f64(ramp_s);
            base.wake(now);
        }
    }
    assert_eq!(now, seconds(64.0));
    let odometer = base.kinematics.state_at(now).steered.to_degrees();
    (odometer, base.turret_heading_at(now).deg())
}

/// E = |odometry| - |true|: the paper's -2 deg clockwise and -6 deg counter-clockwise.
#[test]
fn odometry_errs_on_a_lap_as_in_the_paper() {
    for (direction, error_deg) in [(-1.0, -2.0), (1.0, -6.0)] {
        let patient = BaseParameters {
            command_timeout_s: f64::INFINITY,
            ..papers_base()
        };
        let (odometer, truth) = lap(&mut base(patient), direction);
        assert!((odometer.abs() - 360.0).abs() < 1e-6, "{odometer}");
        let error = odometer.abs() - truth.abs();
        // 1.1 % is 3.96 deg of the 4.
        assert!((error - error_deg).abs() < 0.05, "{error}");
    }
}

#[test]
fn an_ideal_base_returns_from_a_lap() {
    let ideal = BaseParameters {
        command_timeout_s: f64::INFINITY,
        ..Default::default()
    };
    let mut base = base(ideal);
    let (_, truth) = lap(&mut base, 1.0);
    let pose = base.truth_at(seconds(64.0)).pose;
    assert!((truth - 360.0).abs() < 1e-6);
    assert!(
        pose.x.abs().m() < 1e-6 && pose.y.abs().m() < 1e-6,
        "{pose:?}"
    );
}

#[test]
fn silence_stops_the_base_and_is_reported() {
    let mut base = base(BaseParameters::default());
    base.request(Timestamp::ZERO, velocity(0.5, 0.0));
    let log = motions(replies(&mut base, Timestamp::ZERO, seconds(5.0)));
    // 0.25 m/s^2 for the time-out of 0.5 s, and back.
    let (stopped_at, last) = log
        .iter()
        .find(|(_, motion)| motion.command_timed_out && !motion.moving)
        .unwrap();
    assert_eq!(*stopped_at, seconds(1.0));
    assert!((last.displacement.m() - 0.0625).abs() < 1e-4);
    base.request(seconds(5.0), velocity(0.1, 0.0));
    assert!(
        !motions(replies(&mut base, seconds(5.0), seconds(5.0)))[0]
            .1
            .command_timed_out
    );
    // A command to stand still has nothing to run out of.
    base.request(seconds(5.0), velocity(0.0, 0.0));
    assert!(
        motions(replies(&mut base, seconds(5.0), seconds(9.0)))
            .iter()
            .all(|(_, m)| !m.command_timed_out)
    );
}

#[test]
fn limits_of_the_hardware_hold() {
    let mut base = base(BaseParameters {
        command_timeout_s: f64::INFINITY,
        ..Default::default()
    });
    base.request(
        Timestamp::ZERO,
        Request::SetAcceleration {
            drive: Acceleration::from_m_per_s2(5.0),
            steer: AngularAcceleration::from_deg_per_s2(6_000.0),
        },
    );
    base.request(Timestamp::ZERO, velocity(-2.0, 300.0));
    base.wake(seconds(0.5));
    let truth = base.truth_at(seconds(0.5));
    assert!((truth.speed.m_per_s() + 0.25).abs() < 1e-9);
    assert!((truth.steer_rate.deg_per_s() - 60.0).abs() < 1e-9);
    base.wake(seconds(5.0));
    let truth = base.truth_at(seconds(5.0));
    assert!((truth.speed.m_per_s() + 0.78).abs() < 1e-12);
    assert!((truth.steer_rate.deg_per_s() - 120.0).abs() < 1e-9);
    base.request(seconds(5.0), velocity(f64::NAN, f64::NAN));
    base.wake(seconds(10.0));
    assert_eq!(base.truth_at(seconds(10.0)).speed, Speed::ZERO);
}

#[test]
fn a_pose_is_written_at_rest_only() {
    let mut base = base(papers_base());
    let pose = Pose {
        x: Length::from_m(1.0),
        y: Length::from_m(-2.0),
        heading: Angle::from_deg(10.14),
    };
    let write = |counter| Request::WritePose { pose, counter };
    let result = |base: &mut BaseEmulator, at| {
        let motion = motions(replies(base, at, at)).last().unwrap().1;
        (motion.pose_write, motion.pose_write_counter)
    };
    base.request(Timestamp::ZERO, write(1));
    assert_eq!(
        result(&mut base, Timestamp::ZERO),
        (PoseWriteResult::Accepted, 1)
    );
    base.request(seconds(1.0), velocity(0.2, 0.0));
    base.request(seconds(1.1), write(2));
    assert_eq!(
        result(&mut base, seconds(1.1)),
        (PoseWriteResult::RefusedInMotion, 2)
    );
    let written = replies(&mut base, seconds(1.1), seconds(5.0))
        .into_iter()
        .rev()
        .find_map(|(_, reply)| match reply {
            Reply::Pose(pose) => Some(pose),
            Reply::Motion(_) => None,
        });
    let (driven, heading) = (written.unwrap(), pose.heading);
    // As fine as it was written, and dead-reckoned from there: 0.1 m forward before it timed out.
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
    assert_eq!(
        log.iter().map(|(at, _)| *at).collect::<Vec<_>>(),
        [0.0, 0.5, 1.0].map(seconds)
    );
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
    assert!(
        sequences
            .windows(2)
            .all(|pair| pair[1] == pair[0].wrapping_add(1))
    );
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
    assert_eq!(
        log.iter().find(|(_, motion)| !motion.moving).unwrap().0,
        seconds(0.6)
    );
    base.set_emergency_stop(seconds(2.0), false);
    base.request(seconds(2.0), velocity(0.1, 0.0));
    assert!(
        motions(replies(&mut base, seconds(2.0), seconds(2.1)))
            .last()
            .unwrap()
            .1
            .moving
    );
}

#[test]
fn a_carried_base_knows_nothing_of_it() {
    let mut base = base(papers_base());
    let pose = Pose {
        x: Length::from_m(3.0),
        y: Length::ZERO,
        heading: Angle::from_deg(90.0),
    };
    assert!(base.place(Timestamp::ZERO, pose));
    assert_eq!(base.truth_at(Timestamp::ZERO).pose, pose);
    base.request(Timestamp::ZERO, velocity(0.1, 0.0));
    assert!(!base.place(seconds(0.2), pose));
    let reported = replies(&mut base, Timestamp::ZERO, seconds(0.2));
    assert!(
        reported
            .iter()
            .any(|(_, reply)| matches!(reply, Reply::Pose(p) if *p == Pose::default()))
    );
}

#[test]
fn the_serial_line_answers_writes_and_reads() {
    let mut base = BaseEmulator::new(papers_base(), Transport::Serial, 1, "base");
    assert_eq!(base.next_wakeup(), None);
    let mut host = Host::new();
    let mut exchange = |base: &mut BaseEmulator, now, request| {
        let line = host.start(&request).unwrap();
        for byte in line.as_slice() {
            base.receive_bytes(now, &[*byte]);
        }
        let mut events = Vec::new();
        while let Some(BaseOutput::Bytes(bytes)) = base.transmit() {
            host.feed(bytes.as_slice(), |event| events.push(event));
        }
        events
    };
    let written = exchange(&mut base, Timestamp::ZERO, velocity(0.2, 0.0));
    assert!(
        matches!(written[..], [HostEvent::Written(_)]),
        "{written:?}"
    );
    let read = exchange(&mut base, seconds(0.4), Request::ReadMotion);
    let [HostEvent::Reply(Reply::Motion(motion))] = read[..] else {
        panic!("{read:?}")
    };
    assert!(motion.moving && (motion.displacement.m() - 0.02).abs() < 1e-4);
    let read = exchange(&mut base, seconds(0.4), Request::ReadPose);
    assert!(
        matches!(read[..], [HostEvent::Reply(Reply::Pose(_))]),
        "{read:?}"
    );
}

#[test]
fn spread_is_drawn_at_each_start_and_for_this_base_alone() {
    let parameters = BaseParameters {
        turn_scale_spread: 0.01,
        command_timeout_s: 10.0,
        ..Default::default()
    };
    let turns = |name| {
        let mut base = BaseEmulator::new(parameters.clone(), Transport::Can, 1, name);
        [0.0, 20.0].map(|start| {
            base.request(seconds(start), velocity(0.0, 10.0));
            base.request(seconds(start + 9.0), velocity(0.0, 0.0));
            let before = base.kinematics.state_at(seconds(start + 9.0)).truth.steer;
            base.wake(seconds(start + 15.0));
            base.truth_at(seconds(start + 15.0)).steering_angle.rad() - before
        })
    };
    assert_eq!(turns("a"), turns("a"));
    assert_ne!(turns("a")[0], turns("a")[1]);
    assert_ne!(turns("a"), turns("b"));
}

fn any_request() -> impl Strategy<Value = Request> {
    prop_oneof![
        4 => (-1f64..1.0, -150f64..150.0).prop_map(|(v, w)| velocity(v, w)),
        1 => (0.05f64..1.0, 5f64..200.0).prop_map(|(drive, steer)| Request::SetAcceleration {
            drive: Acceleration::from_m_per_s2(drive),
            steer: AngularAcceleration::from_deg_per_s2(steer),
        }),
        1 => Just(Request::Stop),
    ]
}

proptest! {
    /// However often the base is looked at, it is in the same place: to the last bit.
    #[test]
    fn looking_changes_nothing(
        requests in prop::collection::vec((1i64..2_000_000_000, any_request()), 1..8),
        looks in prop::collection::vec(1i64..50_000_000, 1..20),
    ) {
        let crooked = BaseParameters {
            wheels: vec![super::Wheel { x_m: 0.25, toe_deg: 0.1, ..Default::default() }],
            ..papers_base()
        };
        let mut seldom = base(crooked.clone());
        let mut often = base(crooked);
        let mut now = Timestamp::ZERO;
        for (gap, request) in requests {
            let next = now + Span::from_nanos(gap);
            for look in looks.iter().cycle() {
                now += Span::from_nanos(*look);
                if now >= next {
                    break;
                }
                often.wake(now);
                often.truth_at(now);
            }
            now = next;
            seldom.request(now, request);
            often.request(now, request);
            prop_assert_eq!(seldom.truth_at(now), often.truth_at(now));
            prop_assert_eq!(seldom.kinematics.state_at(now), often.kinematics.state_at(now));
        }
    }

    /// Between any two instants the truth moves no faster than the limits.
    #[test]
    fn motion_is_continuous(requests in prop::collection::vec((1i64..800, any_request()), 1..8)) {
        let mut base = base(papers_base());
        let mut now = Timestamp::ZERO;
        let mut last = base.truth_at(now);
        for (steps, request) in requests {
            base.request(now, request);
            for _ in 0..steps {
                now += Span::from_millis(1);
                base.wake(now);
                let next = base.truth_at(now);
                let moved = libm::hypot(
                    (next.pose.x - last.pose.x).m(),
                    (next.pose.y - last.pose.y).m(),
                );
                prop_assert!(moved <= 0.78e-3 + 1e-12);
                prop_assert!((next.speed - last.speed).abs().m_per_s() <= 0.5e-3 + 1e-12);
                let turned = (next.steering_angle - last.steering_angle).abs();
                prop_assert!(turned.deg() <= 0.120 * 1.011 + 1e-9);
                last = next;
            }
        }
    }
}
