//! The shipped DBC file and the hand-written payload codec describe the same bytes.
//!
//! The file is parsed by `can-dbc`; a generic reader and writer of signals ([`layout`]) then treats it as the only
//! authority and is compared with the codec in both directions ([`agreement`]).

mod agreement;
mod layout;

use agreement::RESULTS;
use can_dbc::{AttributeValue, ValueType};
use layout::{ROUNDING, counts, dbc, id_of, mask, message_of, name_of, number, read, signals};
use wire::base::can_link::{parse_reply, parse_request, reply_frame, request_frame};
use wire::base::{HEADING_STEP, Message, Motion, Reply, Request};
use wire::can::{CanFrame, StandardId};
use wire::units::{AngularRate, Length, Pose, Speed};

#[test]
fn the_file_has_these_messages_and_no_others() {
    let dbc = dbc();
    let found: Vec<_> = dbc
        .messages
        .iter()
        .map(|entry| (entry.id, entry.name.as_str(), entry.size, entry.transmitter.as_deref()))
        .collect();
    let expected = Message::ALL.map(|message| {
        let sender = if message.is_reply() { "BASE" } else { "HOST" };
        (id_of(message), name_of(message), message.payload_bytes() as u64, Some(sender))
    });
    assert_eq!(found, expected);
    for entry in &dbc.messages {
        let receiver = if entry.transmitter.as_deref() == Some("BASE") { "HOST" } else { "BASE" };
        for signal in &entry.signals {
            assert_eq!(signal.receivers, [receiver], "{}", signal.name);
        }
    }
    let nodes: Vec<_> = dbc.nodes.iter().map(|node| node.0.as_str()).collect();
    assert_eq!(nodes, ["HOST", "BASE"]);
}

#[test]
fn signals_lie_inside_their_message_and_do_not_overlap() {
    let dbc = dbc();
    for entry in &dbc.messages {
        let mut taken = 0;
        for signal in &entry.signals {
            assert!(signal.start_bit + signal.size <= 8 * entry.size, "{}", signal.name);
            assert_eq!(taken & mask(signal), 0, "{} overlaps", signal.name);
            taken |= mask(signal);
            let (least, greatest) = counts(signal);
            let fits = match signal.value_type {
                ValueType::Signed => -(1 << (signal.size - 1))..=(1i64 << (signal.size - 1)) - 1,
                ValueType::Unsigned => 0..=(1i64 << signal.size) - 1,
            };
            assert!(fits.contains(&least) && fits.contains(&greatest), "{}", signal.name);
            assert!(least < greatest, "{}", signal.name);
        }
    }
}

#[test]
fn units_are_those_of_the_field() {
    for entry in &dbc().messages {
        for signal in &entry.signals {
            let unit = match signal.name.as_str() {
                "X" | "Y" | "DISPLACEMENT" => "m",
                "HEADING" => "deg",
                "DRIVE_SPEED" => "m/s",
                "STEER_RATE" => "deg/s",
                "DRIVE_ACCELERATION" => "m/s^2",
                "STEER_ACCELERATION" => "deg/s^2",
                _ => "",
            };
            assert_eq!(signal.unit, unit, "{}", signal.name);
        }
    }
    let dbc = dbc();
    let heading = dbc.signal_by_name(id_of(Message::Motion), "HEADING").unwrap();
    assert_eq!(heading.factor, HEADING_STEP.deg());
}

#[test]
fn numbers_beyond_the_range_are_clipped_to_the_declared_one() {
    let dbc = dbc();
    for sign in [-1.0, 1.0] {
        let far = 1e6 * sign;
        let request = Request::SetVelocity {
            drive: Speed::from_m_per_s(far),
            steer: AngularRate::from_deg_per_s(far),
        };
        let pose = Pose { x: Length::from_m(far), y: Length::from_m(far), ..Pose::default() };
        let motion = Motion { displacement: Length::from_m(far), ..Motion::default() };
        let frames = [
            request_frame(&request).unwrap(),
            reply_frame(&Reply::Pose(pose)),
            reply_frame(&Reply::Motion(motion)),
        ];
        for frame in frames {
            for signal in signals(&dbc, message_of(&frame)) {
                if ["DRIVE_SPEED", "STEER_RATE", "X", "Y", "DISPLACEMENT"].contains(&&*signal.name)
                {
                    let end = if sign > 0.0 { signal.max } else { signal.min };
                    let found = read(signal, frame.data());
                    assert!((found - number(end)).abs() < ROUNDING, "{}: {found}", signal.name);
                }
            }
        }
    }
}

#[test]
fn the_results_of_a_pose_write_are_named() {
    let dbc = dbc();
    let named = dbc.value_descriptions_for_signal(id_of(Message::Motion), "POSE_WRITE_RESULT");
    let named: Vec<_> =
        named.unwrap().iter().map(|value| (value.id, value.description.as_str())).collect();
    let expected = [(0, "none"), (1, "accepted"), (2, "refused in motion"), (3, "refused value")];
    assert_eq!(named, expected);
    for (result, (id, _)) in RESULTS.into_iter().zip(expected) {
        let frame = reply_frame(&Reply::Motion(Motion { pose_write: result, ..Motion::default() }));
        let signal = dbc.signal_by_name(id_of(Message::Motion), "POSE_WRITE_RESULT").unwrap();
        assert_eq!(read(signal, frame.data()), id as f64);
    }
}

#[test]
fn each_message_and_each_signal_is_explained() {
    let dbc = dbc();
    for entry in &dbc.messages {
        assert!(dbc.message_comment(entry.id).is_some(), "{}", entry.name);
        for signal in &entry.signals {
            assert!(dbc.signal_comment(entry.id, &signal.name).is_some(), "{}", signal.name);
        }
    }
}

#[test]
fn cycle_times() {
    let dbc = dbc();
    for (message, cycle_ms) in Message::ALL.into_iter().zip([27, 0, 0, 0, 20, 500]) {
        let found = dbc.resolved_message_attribute(id_of(message), "GenMsgCycleTime");
        assert_eq!(found, Some(&AttributeValue::Uint(cycle_ms)), "{}", name_of(message));
    }
}

#[test]
fn other_identifiers_are_not_of_the_command_set() {
    let known = Message::ALL.map(|message| message.can_id().as_raw());
    for raw in (0..=StandardId::MAX.as_raw()).filter(|raw| !known.contains(raw)) {
        let frame = CanFrame::full(StandardId::new(raw).unwrap(), [0; 8]);
        assert_eq!((parse_request(&frame), parse_reply(&frame)), (None, None));
    }
}
