//! Round trips and the rules for values out of range; generators for the tests of both transports.

use super::{
    COUNTS_PER_DEG, COUNTS_PER_M, MOTION_HEADING_STEPS, PAYLOAD_BYTES_MAX, POSE_HEADING_STEPS,
    Payload, decode_reply, decode_request, encode_reply, encode_request,
};
use crate::base::{
    HEADING_STEP, Message, Motion, POSE_WRITE_MODULUS, PoseWriteResult, Reply, Request,
};
use crate::units::{Acceleration, Angle, AngularAcceleration, AngularRate, Length, Pose, Speed};
use proptest::prelude::*;

/// A request with ordinary and absurd numbers.
pub(in crate::base) fn any_request() -> impl Strategy<Value = Request> {
    prop_oneof![
        (number(4.0), number(400.0)).prop_map(|(drive, steer)| velocity(drive, steer)),
        (number(8.0), number(800.0)).prop_map(|(drive, steer)| limits(drive, steer)),
        (any_pose(), any::<u8>()).prop_map(|(pose, counter)| Request::WritePose { pose, counter }),
        Just(Request::Stop),
        Just(Request::ReadMotion),
        Just(Request::ReadPose),
    ]
}

/// A reply with ordinary and absurd numbers.
pub(in crate::base) fn any_reply() -> impl Strategy<Value = Reply> {
    prop_oneof![any_pose().prop_map(Reply::Pose), any_motion().prop_map(Reply::Motion)]
}

/// A request after transport: rounded and clipped; `None` if it is not sent.
pub(in crate::base) fn carried_request(request: &Request) -> Option<Request> {
    let (message, payload) = encode_request(request)?;
    decode_request(message, payload.as_slice())
}

/// A reply after transport: rounded and clipped.
pub(in crate::base) fn carried_reply(reply: &Reply) -> Reply {
    let (message, payload) = encode_reply(reply);
    decode_reply(message, payload.as_slice()).unwrap()
}

/// Mostly within `usual`, sometimes any number.
fn number(usual: f64) -> impl Strategy<Value = f64> {
    prop_oneof![4 => -usual..usual, 1 => any::<f64>()]
}

fn any_pose() -> impl Strategy<Value = Pose> {
    (number(420.0), number(420.0), number(720.0)).prop_map(|(x, y, heading)| pose(x, y, heading))
}

fn any_motion() -> impl Strategy<Value = Motion> {
    let results = [
        PoseWriteResult::None,
        PoseWriteResult::Accepted,
        PoseWriteResult::RefusedInMotion,
        PoseWriteResult::RefusedValue,
    ];
    let flags = any::<[bool; 4]>();
    let result = prop::sample::select(results.to_vec());
    (number(1e5), number(720.0), flags, result, any::<u8>(), any::<u8>()).prop_map(
        |(displacement, heading, flags, pose_write, pose_write_counter, sequence)| Motion {
            displacement: Length::from_m(displacement),
            heading: Angle::from_deg(heading),
            moving: flags[0],
            command_timed_out: flags[1],
            emergency_stop: flags[2],
            fault: flags[3],
            pose_write,
            pose_write_counter,
            sequence,
        },
    )
}

fn velocity(drive_m_per_s: f64, steer_deg_per_s: f64) -> Request {
    Request::SetVelocity {
        drive: Speed::from_m_per_s(drive_m_per_s),
        steer: AngularRate::from_deg_per_s(steer_deg_per_s),
    }
}

fn limits(drive_m_per_s2: f64, steer_deg_per_s2: f64) -> Request {
    Request::SetAcceleration {
        drive: Acceleration::from_m_per_s2(drive_m_per_s2),
        steer: AngularAcceleration::from_deg_per_s2(steer_deg_per_s2),
    }
}

fn pose(x_m: f64, y_m: f64, heading_deg: f64) -> Pose {
    Pose { x: Length::from_m(x_m), y: Length::from_m(y_m), heading: Angle::from_deg(heading_deg) }
}

/// Half a count plus the rounding of floating point.
fn half(counts_per_unit: f64) -> f64 {
    0.5 / counts_per_unit + 1e-9
}

#[track_caller]
fn check_direction(sent: Angle, came: Angle, tolerance_deg: f64) {
    let error_deg = (sent - came).wrapped().abs().deg();
    assert!(error_deg <= tolerance_deg, "{sent:?} came as {came:?}");
    assert!((-180.0..180.0).contains(&came.deg()), "{came:?} is not wrapped");
}

fn check_pose(sent: Pose, came: Pose) {
    assert!((sent.x - came.x).abs().m() <= half(COUNTS_PER_M), "{sent:?} came as {came:?}");
    assert!((sent.y - came.y).abs().m() <= half(COUNTS_PER_M), "{sent:?} came as {came:?}");
    check_direction(sent.heading, came.heading, half(COUNTS_PER_DEG));
}

proptest! {
    #[test]
    fn a_velocity_in_range_comes_within_half_a_count(drive in -3.27f64..3.27, steer in -327.0f64..327.0) {
        let Some(Request::SetVelocity { drive: d, steer: s }) =
            carried_request(&velocity(drive, steer)) else { panic!("a velocity always has a payload") };
        prop_assert!((d.m_per_s() - drive).abs() <= half(COUNTS_PER_M));
        prop_assert!((s.deg_per_s() - steer).abs() <= half(COUNTS_PER_DEG));
    }

    #[test]
    fn a_limit_in_range_comes_within_half_a_count(drive in 1e-4f64..6.55, steer in 0.01f64..655.0) {
        let Some(Request::SetAcceleration { drive: d, steer: s }) =
            carried_request(&limits(drive, steer)) else { panic!("both limits are above zero") };
        prop_assert!((d.m_per_s2() - drive).abs() <= half(COUNTS_PER_M));
        prop_assert!((s.deg_per_s2() - steer).abs() <= half(COUNTS_PER_DEG));
    }

    #[test]
    fn a_pose_in_range_comes_within_half_a_count(
        x in -419.0f64..419.0, y in -419.0f64..419.0, heading in -720.0f64..720.0, counter: u8,
    ) {
        let sent = pose(x, y, heading);
        let Some(Request::WritePose { pose: came, counter: c }) =
            carried_request(&Request::WritePose { pose: sent, counter }) else { panic!("in range") };
        prop_assert_eq!(c, counter % POSE_WRITE_MODULUS);
        check_pose(sent, came);
        let Reply::Pose(came) = carried_reply(&Reply::Pose(sent)) else { panic!("a pose") };
        check_pose(sent, came);
    }

    #[test]
    fn a_motion_comes_whole(motion in any_motion()) {
        let Reply::Motion(came) = carried_reply(&Reply::Motion(motion)) else { panic!("a motion") };
        if motion.displacement.abs().m() < 2e5 {
            prop_assert!((came.displacement - motion.displacement).abs().m() <= half(COUNTS_PER_M));
        }
        if motion.heading.abs().deg() <= 720.0 {
            check_direction(motion.heading, came.heading, HEADING_STEP.deg() / 2.0 + 1e-9);
        }
        let expected = Motion {
            displacement: came.displacement,
            heading: came.heading,
            pose_write_counter: motion.pose_write_counter % POSE_WRITE_MODULUS,
            ..motion
        };
        prop_assert_eq!(came, expected);
    }

    #[test]
    fn what_came_once_is_sent_unchanged(request in any_request(), reply in any_reply()) {
        if let Some(request) = carried_request(&request) {
            prop_assert_eq!(carried_request(&request), Some(request));
        }
        let reply = carried_reply(&reply);
        prop_assert_eq!(carried_reply(&reply), reply);
    }

    #[test]
    fn any_bytes_make_finite_numbers_or_nothing(
        message in prop::sample::select(Message::ALL.to_vec()),
        bytes in prop::collection::vec(any::<u8>(), 0..=PAYLOAD_BYTES_MAX + 1),
    ) {
        let fits = bytes.len() == message.payload_bytes();
        let reply = decode_reply(message, &bytes);
        prop_assert_eq!(reply.is_some(), fits && message.is_reply());
        match reply {
            Some(Reply::Pose(pose)) => prop_assert!(pose.is_finite()),
            Some(Reply::Motion(motion)) => {
                prop_assert!(motion.displacement.is_finite() && motion.heading.is_finite());
            }
            None => {}
        }
        let request = decode_request(message, &bytes);
        if message != Message::SetAcceleration {
            prop_assert_eq!(request.is_some(), fits && !message.is_reply());
        }
        if let Some(request) = request {
            prop_assert_eq!(encode_request(&request).map(|(message, _)| message), Some(message));
        }
    }
}

#[test]
fn a_velocity_is_clipped_and_a_broken_one_is_zero() {
    for (asked, carried) in [
        (velocity(9.0, 999.0), velocity(3.2767, 327.67)),
        (velocity(-9.0, -999.0), velocity(-3.2768, -327.68)),
        (velocity(f64::NAN, 30.0), velocity(0.0, 30.0)),
        (velocity(0.4, f64::NAN), velocity(0.4, 0.0)),
        (velocity(f64::INFINITY, f64::NEG_INFINITY), velocity(0.0, 0.0)),
        (velocity(0.4, -30.0), velocity(0.4, -30.0)),
    ] {
        assert_eq!(carried_request(&asked), Some(carried));
    }
}

#[test]
fn a_limit_with_which_the_base_could_not_stop_is_refused() {
    for bad in [0.0, -0.25, f64::NAN, f64::INFINITY] {
        assert_eq!(encode_request(&limits(bad, 21.0)), None);
        assert_eq!(encode_request(&limits(0.25, bad)), None);
    }
    assert_eq!(carried_request(&limits(1e-9, 1e-9)), Some(limits(0.0001, 0.01)));
    assert_eq!(carried_request(&limits(99.0, 9e9)), Some(limits(6.5535, 655.35)));
    assert_eq!(decode_request(Message::SetAcceleration, &[0, 0, 1, 0]), None);
    assert_eq!(decode_request(Message::SetAcceleration, &[1, 0, 0, 0]), None);
}

#[test]
fn a_pose_out_of_range_is_refused_not_clipped() {
    for (pose, sent) in [
        (pose(419.4303, -419.4304, 0.0), true),
        (pose(419.4304, 0.0, 0.0), false),
        (pose(0.0, -419.4305, 0.0), false),
        (pose(f64::NAN, 0.0, 0.0), false),
        (pose(0.0, f64::INFINITY, 0.0), false),
        (pose(0.0, 0.0, f64::NAN), false),
        (pose(0.0, 0.0, 7_200.0), true),
        (pose(0.0, 0.0, 1e12), false),
    ] {
        let request = Request::WritePose { pose, counter: 1 };
        assert_eq!(encode_request(&request).is_some(), sent, "{pose:?}");
    }
}

#[test]
fn half_a_turn_is_sent_as_the_closed_end_of_the_circle() {
    for heading in [180.0, -180.0, 179.999, 540.0] {
        let (_, payload) = encode_reply(&Reply::Pose(pose(0.0, 0.0, heading)));
        assert_eq!(payload.as_slice()[6..], (-18_000i16).to_le_bytes());
        let motion = Motion { heading: Angle::from_deg(heading), ..Motion::default() };
        let (_, payload) = encode_reply(&Reply::Motion(motion));
        assert_eq!(payload.as_slice()[4..6], (-600i16).to_le_bytes());
    }
}

#[test]
fn a_heading_from_beyond_the_circle_is_the_same_direction() {
    for (counts, deg) in [(24_576i16, -114.24), (-18_001, 179.99), (18_000, -180.0), (9_000, 90.0)]
    {
        let mut bytes = [0; 8];
        bytes[6..].copy_from_slice(&counts.to_le_bytes());
        let Some(Reply::Pose(pose)) = decode_reply(Message::Pose, &bytes) else { panic!("a pose") };
        assert!((pose.heading.deg() - deg).abs() < 1e-9, "{counts}: {pose:?}");
    }
}

#[test]
fn a_motion_counts_its_heading_in_steps_of_the_odometry() {
    let turn = HEADING_STEP * f64::from(MOTION_HEADING_STEPS);
    assert!((turn - Angle::TURN).abs().rad() < 1e-12);
    assert_eq!(f64::from(POSE_HEADING_STEPS), 360.0 * COUNTS_PER_DEG);
}

#[test]
fn known_payloads() {
    let motion = Reply::Motion(Motion {
        displacement: Length::from_m(-4.0),
        heading: Angle::from_deg(-90.0),
        moving: true,
        fault: true,
        pose_write: PoseWriteResult::RefusedInMotion,
        pose_write_counter: 3,
        sequence: 200,
        ..Motion::default()
    });
    // -40,000 counts, -300 steps, result 2 and counter 3.
    let bytes = [0xC0, 0x63, 0xFF, 0xFF, 0xD4, 0xFE, 0b1110_1001, 200];
    assert_eq!(encode_reply(&motion), (Message::Motion, Payload::full(bytes)));

    let request = Request::WritePose { pose: pose(4.0, -0.0001, 90.0), counter: 5 };
    // x = 40,000 in bits 0-22, y = -1 in bits 23-45, counter 1 in bits 46-47, heading 9,000.
    let bytes = [0x40, 0x9C, 0x80, 0xFF, 0xFF, 0x7F, 0x28, 0x23];
    assert_eq!(encode_request(&request), Some((Message::WritePose, Payload::full(bytes))));

    assert_eq!(
        encode_request(&velocity(0.4, -30.0)).map(|(_, payload)| payload),
        Payload::from_slice(&[0xA0, 0x0F, 0x48, 0xF4]),
    );
    assert_eq!(
        encode_request(&Request::Stop).map(|(_, payload)| payload),
        Payload::from_slice(&[0]),
    );
    assert_eq!(Payload::from_slice(&[0; PAYLOAD_BYTES_MAX + 1]), None);
}
