//! Layout and codec agree in both directions, for any content.

use crate::layout::{ROUNDING, counts, dbc, mask, message_of, name_of, number, read, signals};
use can_dbc::Dbc;
use proptest::prelude::*;
use wire::base::can_link::{parse_reply, parse_request, reply_frame, request_frame};
use wire::base::serial_link::{COMPUTER_ID, Host, Line, LineDecoder};
use wire::base::{Message, Motion, POSE_WRITE_MODULUS, PoseWriteResult, Reply, Request};
use wire::can::CanFrame;
use wire::units::{Acceleration, Angle, AngularAcceleration, AngularRate, Length, Pose, Speed};

/// By the count that encodes each.
pub const RESULTS: [PoseWriteResult; 4] = [
    PoseWriteResult::None,
    PoseWriteResult::Accepted,
    PoseWriteResult::RefusedInMotion,
    PoseWriteResult::RefusedValue,
];

/// A request's numbers by signal name, in the units of the file.
fn request_values(request: &Request) -> Vec<(&'static str, f64)> {
    match *request {
        Request::SetVelocity { drive, steer } => {
            vec![("DRIVE_SPEED", drive.m_per_s()), ("STEER_RATE", steer.deg_per_s())]
        }
        Request::SetAcceleration { drive, steer } => vec![
            ("DRIVE_ACCELERATION", drive.m_per_s2()),
            ("STEER_ACCELERATION", steer.deg_per_s2()),
        ],
        Request::WritePose { pose, counter } => {
            let mut values = pose_values(pose);
            values.push(("POSE_WRITE_COUNTER", f64::from(counter % POSE_WRITE_MODULUS)));
            values
        }
        Request::Stop | Request::ReadMotion | Request::ReadPose => vec![],
    }
}

/// A reply's numbers by signal name, in the units of the file.
fn reply_values(reply: &Reply) -> Vec<(&'static str, f64)> {
    let flag = |set: bool| f64::from(u8::from(set));
    match *reply {
        Reply::Pose(pose) => pose_values(pose),
        Reply::Motion(motion) => vec![
            ("DISPLACEMENT", motion.displacement.m()),
            ("HEADING", motion.heading.deg()),
            ("MOVING", flag(motion.moving)),
            ("COMMAND_TIMED_OUT", flag(motion.command_timed_out)),
            ("EMERGENCY_STOP", flag(motion.emergency_stop)),
            ("FAULT", flag(motion.fault)),
            (
                "POSE_WRITE_RESULT",
                RESULTS
                    .iter()
                    .position(|result| *result == motion.pose_write)
                    .expect("all are listed") as f64,
            ),
            ("POSE_WRITE_COUNTER", f64::from(motion.pose_write_counter % POSE_WRITE_MODULUS)),
            ("SEQUENCE", f64::from(motion.sequence)),
        ],
    }
}

fn pose_values(pose: Pose) -> Vec<(&'static str, f64)> {
    vec![("X", pose.x.m()), ("Y", pose.y.m()), ("HEADING", pose.heading.deg())]
}

/// Each signal of `message`, read by the file's layout, equals the value of its name within half a count, and each
/// value has its signal.
fn check(dbc: &Dbc, message: Message, data: &[u8], values: &[(&'static str, f64)]) {
    let signals = signals(dbc, message);
    assert_eq!(signals.len(), values.len(), "{}", name_of(message));
    for signal in signals {
        let named = values.iter().find(|(name, _)| *name == signal.name);
        let (_, value) = named.unwrap_or_else(|| panic!("{} is no field", signal.name));
        let found = read(signal, data);
        let mut error = (found - value).abs();
        if signal.name == "HEADING" {
            error = (Angle::from_deg(found) - Angle::from_deg(*value)).wrapped().abs().deg();
        }
        let limit = signal.factor / 2.0 + ROUNDING;
        assert!(error <= limit, "{}: {value} reads as {found}", signal.name);
        assert!(
            found >= number(signal.min) - ROUNDING && found <= number(signal.max) + ROUNDING,
            "{}: {found} is out of the declared range",
            signal.name
        );
    }
}

fn any_pose() -> impl Strategy<Value = Pose> {
    (-419.0f64..419.0, -419.0f64..419.0, -400.0f64..400.0).prop_map(|(x, y, heading)| Pose {
        x: Length::from_m(x),
        y: Length::from_m(y),
        heading: Angle::from_deg(heading),
    })
}

/// Requests with a payload, in range.
fn any_request() -> impl Strategy<Value = Request> {
    prop_oneof![
        (-3.27f64..3.27, -327.0f64..327.0).prop_map(|(drive, steer)| Request::SetVelocity {
            drive: Speed::from_m_per_s(drive),
            steer: AngularRate::from_deg_per_s(steer),
        }),
        (0.0001f64..6.55, 0.01f64..655.0).prop_map(|(drive, steer)| Request::SetAcceleration {
            drive: Acceleration::from_m_per_s2(drive),
            steer: AngularAcceleration::from_deg_per_s2(steer),
        }),
        (any_pose(), any::<u8>()).prop_map(|(pose, counter)| Request::WritePose { pose, counter }),
        Just(Request::Stop),
    ]
}

fn any_reply() -> impl Strategy<Value = Reply> {
    let motion = (
        -200_000.0f64..200_000.0,
        -400.0f64..400.0,
        any::<[bool; 4]>(),
        prop::sample::select(RESULTS.to_vec()),
        any::<[u8; 2]>(),
    );
    prop_oneof![
        any_pose().prop_map(Reply::Pose),
        motion.prop_map(|(displacement, heading, flags, pose_write, numbers)| {
            let [moving, command_timed_out, emergency_stop, fault] = flags;
            let [pose_write_counter, sequence] = numbers;
            Reply::Motion(Motion {
                displacement: Length::from_m(displacement),
                heading: Angle::from_deg(heading),
                moving,
                command_timed_out,
                emergency_stop,
                fault,
                pose_write,
                pose_write_counter,
                sequence,
            })
        }),
    ]
}

proptest! {
    #[test]
    fn the_file_reads_what_the_codec_writes(request in any_request(), reply in any_reply()) {
        let dbc = dbc();
        let frame = request_frame(&request).expect("in range");
        check(&dbc, message_of(&frame), frame.data(), &request_values(&request));
        let frame = reply_frame(&reply);
        check(&dbc, message_of(&frame), frame.data(), &reply_values(&reply));
    }

    #[test]
    fn the_codec_reads_what_the_file_writes(
        message in prop::sample::select(Message::ALL.to_vec()),
        picks in prop::array::uniform9(0.0f64..=1.0),
    ) {
        let dbc = dbc();
        let mut bits = 0;
        for (signal, pick) in signals(&dbc, message).iter().zip(picks) {
            let (least, greatest) = counts(signal);
            let count = least + ((greatest - least) as f64 * pick).round() as i64;
            bits |= (count as u64) << signal.start_bit & mask(signal);
        }
        let data = &bits.to_le_bytes()[..message.payload_bytes()];
        let frame = CanFrame::new(message.can_id(), data).expect("eight bytes or less");
        let (values, again) = match (parse_request(&frame), parse_reply(&frame)) {
            (Some(request), None) => (request_values(&request), request_frame(&request)),
            (None, Some(reply)) => (reply_values(&reply), Some(reply_frame(&reply))),
            both => panic!("{both:?}"),
        };
        check(&dbc, message, data, &values);
        prop_assert_eq!(again, Some(frame));
    }

    #[test]
    fn both_transports_carry_the_same_bytes(request in any_request()) {
        let frame = request_frame(&request).expect("in range");
        let line = Host::default().start(&request).expect("in range");
        let mut decoder = LineDecoder::default();
        let lines: Vec<_> = line.as_slice().iter().filter_map(|byte| decoder.push(*byte)).collect();
        let [Ok(Line::Write { address, computer, data })] = lines[..] else { panic!("{lines:?}") };
        prop_assert_eq!(address, message_of(&frame).register());
        prop_assert_eq!(computer, COMPUTER_ID);
        prop_assert_eq!(data.as_slice(), frame.data());
    }
}
