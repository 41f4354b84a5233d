//! True motion: laps, limits, and independence of the times of reading.

use super::{any_request, base, lap, looked_at, papers_base, replies, seconds, velocity};
use crate::base::{BaseEmulator, BaseParameters, Transport, Wheel};
use proptest::prelude::*;
use wire::base::{Reply, Request};
use wire::time::{Span, Timestamp};
use wire::units::{Acceleration, Angle, AngularAcceleration, Length, Pose, Speed};

/// E = |odometry| - |true|: the paper's -2 deg clockwise and -6 deg counter-clockwise.
#[test]
fn odometry_errs_on_a_lap_as_in_the_paper() {
    for (direction, error_deg) in [(-1.0, -2.0), (1.0, -6.0)] {
        let patient = BaseParameters { command_timeout_s: f64::INFINITY, ..papers_base() };
        let (odometer, truth) = lap(&mut base(patient), direction);
        assert!((odometer.abs() - 360.0).abs() < 1e-6, "{odometer}");
        let error = odometer.abs() - truth.abs();
        // 1.1 % is 3.96 deg of the 4.
        assert!((error - error_deg).abs() < 0.05, "{error}");
    }
}

#[test]
fn an_ideal_base_returns_from_a_lap() {
    let ideal = BaseParameters { command_timeout_s: f64::INFINITY, ..Default::default() };
    let mut base = base(ideal);
    let (_, truth) = lap(&mut base, 1.0);
    let pose = base.truth_at(seconds(64.0)).pose;
    assert!((truth - 360.0).abs() < 1e-6);
    assert!(pose.x.abs().m() < 1e-6 && pose.y.abs().m() < 1e-6, "{pose:?}");
}

#[test]
fn limits_of_the_hardware_hold() {
    let mut base = base(BaseParameters { command_timeout_s: f64::INFINITY, ..Default::default() });
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
fn a_carried_base_knows_nothing_of_it() {
    let mut base = base(papers_base());
    let pose = Pose { x: Length::from_m(3.0), y: Length::ZERO, heading: Angle::from_deg(90.0) };
    assert!(base.place(Timestamp::ZERO, pose));
    assert_eq!(base.truth_at(Timestamp::ZERO).pose, pose);
    base.request(Timestamp::ZERO, velocity(0.1, 0.0));
    assert!(!base.place(seconds(0.2), pose));
    let reported = replies(&mut base, Timestamp::ZERO, seconds(0.2));
    assert!(
        reported.iter().any(|(_, reply)| matches!(reply, Reply::Pose(p) if *p == Pose::default()))
    );
}

#[test]
fn spread_is_drawn_at_each_start_and_for_this_base_alone() {
    let parameters =
        BaseParameters { turn_scale_spread: 0.01, command_timeout_s: 10.0, ..Default::default() };
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

proptest! {
    /// The state does not depend on how often it is read, to the last bit.
    #[test]
    fn looking_changes_nothing(
        requests in prop::collection::vec((1i64..2_000_000_000, any_request()), 1..8),
        looks in prop::collection::vec(1i64..50_000_000, 1..20),
    ) {
        let crooked = BaseParameters {
            wheels: vec![Wheel { x_m: 0.25, toe_deg: 0.1, ..Default::default() }],
            ..papers_base()
        };
        looked_at(crooked, requests, &looks)?;
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
