//! The layout of `wire/dbc/k2a.dbc`, and the hand-written codec of the same messages.

use described::{Layout, Sender};
use proptest::prelude::*;
use std::sync::LazyLock;
use wire::base::can_link::{parse_reply, parse_request, reply_frame, request_frame};
use wire::base::{Motion, PoseWriteResult, Reply, Request};
use wire::device::Transmit;
use wire::units::{Acceleration, Angle, AngularAcceleration, AngularRate, Length, Pose, Speed};

static LAYOUT: LazyLock<Layout> = LazyLock::new(|| {
    Layout::from_dbc("k2a.dbc", include_str!("../../wire/dbc/k2a.dbc"), "BASE")
        .expect("the shipped file is a layout")
});

fn encode(message: &str, values: &[f64]) -> wire::can::CanFrame {
    let index = LAYOUT.find(message).expect("it is in the file");
    match LAYOUT.encode(index, values).expect("they are in range") {
        Transmit::Frame(frame) => frame,
        Transmit::Bytes(_) => panic!("{message} is on CAN"),
    }
}

#[test]
fn the_base_sends_its_two_messages_at_their_periods() {
    let sent: Vec<_> = LAYOUT
        .messages()
        .iter()
        .filter(|message| message.sender == Sender::Device)
        .map(|message| (message.name.as_str(), message.period.map(|period| period.as_nanos())))
        .collect();
    assert_eq!(sent, [("MOTION", Some(20_000_000)), ("POSE", Some(500_000_000))]);
    assert_eq!(LAYOUT.messages()[3].signals, []);
    assert_eq!(encode("STOP", &[]).data(), request_frame(&Request::Stop).unwrap().data());
}

proptest! {
    #[test]
    fn velocities_are_those_of_the_hand_written_codec(drive in -3.2f64..3.2, steer in -327.0f64..327.0) {
        let frame = encode("SET_VELOCITY", &[drive, steer]);
        let request = Request::SetVelocity {
            drive: Speed::from_m_per_s(drive),
            steer: AngularRate::from_deg_per_s(steer),
        };
        prop_assert_eq!(request_frame(&request), Some(frame));
        let Some(Request::SetVelocity { drive, .. }) = parse_request(&frame) else { panic!("refused") };
        let mut decoder = LAYOUT.decoder();
        let found = decoder.frame(&frame).unwrap();
        prop_assert!((found.values[0].unwrap() - drive.m_per_s()).abs() < 1e-12);
    }

    #[test]
    fn limits_are_those_of_the_hand_written_codec(drive in 0.001f64..6.5, steer in 0.1f64..655.0) {
        let frame = encode("SET_ACCELERATION", &[drive, steer]);
        let request = Request::SetAcceleration {
            drive: Acceleration::from_m_per_s2(drive),
            steer: AngularAcceleration::from_deg_per_s2(steer),
        };
        prop_assert_eq!(request_frame(&request), Some(frame));
    }

    #[test]
    fn poses_are_those_of_the_hand_written_codec(x in -419f64..419.0, y in -419f64..419.0, heading in -179f64..179.0) {
            let pose = Pose { x: Length::from_m(x), y: Length::from_m(y), heading: Angle::from_deg(heading) };
        let frame = encode("POSE", &[x, y, heading]);
        prop_assert_eq!(reply_frame(&Reply::Pose(pose)), frame);
        let written = encode("WRITE_POSE", &[x, y, 3.0, heading]);
        prop_assert_eq!(request_frame(&Request::WritePose { pose, counter: 3 }), Some(written));
    }

    #[test]
    fn motions_are_decoded_alike(displacement in -2e5f64..2e5, turns in -179f64..179.0, moving: bool, sequence: u8) {
        let motion = Motion {
            displacement: Length::from_m(displacement),
            heading: Angle::from_deg(turns),
            moving,
            sequence,
            ..Motion::default()
        };
        let frame = reply_frame(&Reply::Motion(motion));
            let mut decoder = LAYOUT.decoder();
            let found = decoder.frame(&frame).unwrap();
        let value = |name: &str| {
            let (message, signal) = LAYOUT.signal(&format!("MOTION.{name}")).unwrap();
            assert_eq!(message, found.message);
            found.values[signal].unwrap()
        };
        let Some(Reply::Motion(parsed)) = parse_reply(&frame) else { panic!("refused") };
        prop_assert!((value("DISPLACEMENT") - parsed.displacement.m()).abs() < 1e-9);
        prop_assert!((value("HEADING") - parsed.heading.deg()).abs() < 1e-9);
        prop_assert_eq!(value("MOVING"), f64::from(u8::from(moving)));
        prop_assert_eq!(value("SEQUENCE"), f64::from(sequence));
        prop_assert_eq!(parsed.pose_write, PoseWriteResult::default());
    }
}
