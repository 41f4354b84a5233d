//! The host's view of the base, compared with the truth.

mod faults;
mod following;
mod imperfections;
mod motion;
mod protocol;

use super::{BaseEmulator, BaseParameters, Transport};
use proptest::prelude::*;
use wire::base::{Motion, Reply, Request, can_link};
use wire::device::Transmit;
use wire::time::{Span, Timestamp};
use wire::units::{Acceleration, AngularAcceleration, AngularRate, Speed};

pub(super) fn seconds(seconds: f64) -> Timestamp {
    Timestamp::from_secs_f64(seconds)
}

pub(super) fn velocity(m_per_s: f64, deg_per_s: f64) -> Request {
    Request::SetVelocity {
        drive: Speed::from_m_per_s(m_per_s),
        steer: AngularRate::from_deg_per_s(deg_per_s),
    }
}

pub(super) fn base(parameters: BaseParameters) -> BaseEmulator {
    BaseEmulator::new(parameters, Transport::Can, 1, "base")
}

/// Of two bases, one is woken and read more often: both are in the same place, to the last bit.
pub(super) fn looked_at(
    parameters: BaseParameters,
    requests: Vec<(i64, Request)>,
    looks: &[i64],
) -> Result<(), TestCaseError> {
    let (mut seldom, mut often) = (base(parameters.clone()), base(parameters));
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
    Ok(())
}

pub(super) fn papers_base() -> BaseParameters {
    BaseParameters {
        turn_scale_error: 0.011,
        leakage_deg_per_m: 0.125,
        heading_step_deg: 0.3,
        ..Default::default()
    }
}

/// Everything sent from `from`, when a request may have arrived, up to `until`.
pub(super) fn replies(
    base: &mut BaseEmulator,
    from: Timestamp,
    until: Timestamp,
) -> Vec<(Timestamp, Reply)> {
    let mut replies = Vec::new();
    let mut now = from;
    loop {
        while let Some(Transmit::Frame(frame)) = base.transmit() {
            replies.push((now, can_link::parse_reply(&frame).unwrap()));
        }
        match base.next_wakeup() {
            Some(at) if at <= until => now = at,
            _ => return replies,
        }
        base.wake(now);
    }
}

pub(super) fn motions(replies: Vec<(Timestamp, Reply)>) -> Vec<(Timestamp, Motion)> {
    let motion = |(at, reply)| match reply {
        Reply::Motion(motion) => Some((at, motion)),
        Reply::Pose(_) => None,
    };
    replies.into_iter().filter_map(motion).collect()
}

/// The paper's lap, closed by odometry: a 4 x 4 m square at 0.4 m/s and 30 deg/s, 64 s. Returns the rotation of the
/// odometer and of the turret, in degrees.
pub(super) fn lap(base: &mut BaseEmulator, direction: f64) -> (f64, f64) {
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

pub(super) fn any_request() -> impl Strategy<Value = Request> {
    prop_oneof![
        4 => (-1f64..1.0, -150f64..150.0).prop_map(|(v, w)| velocity(v, w)),
        1 => (0.05f64..1.0, 5f64..200.0).prop_map(|(drive, steer)| Request::SetAcceleration {
            drive: Acceleration::from_m_per_s2(drive),
            steer: AngularAcceleration::from_deg_per_s2(steer),
        }),
        1 => Just(Request::Stop),
    ]
}
