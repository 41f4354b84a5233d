//! Both ends of the serial line against each other, and against garbage.

use super::{
    ANSWER_BYTES_MAX, COMPUTER_ID, Device, DeviceEvent, Host, HostEvent, Line, ReadAnswer, Refusal,
    SETTINGS, quiet_time, write_answer,
};
use crate::base::payload::tests::{any_reply, any_request, carried_reply, carried_request};
use crate::base::payload::{Payload, encode_reply};
use crate::base::{Message, Motion, Reply, Request};
use crate::time::Span;
use crate::units::Pose;
use proptest::prelude::*;
use std::vec::Vec;

fn device_events(device: &mut Device, bytes: &[u8]) -> Vec<DeviceEvent> {
    let mut events = Vec::new();
    device.feed(bytes, |event| events.push(event));
    events
}

fn host_events(host: &mut Host, bytes: &[u8]) -> Vec<HostEvent> {
    let mut events = Vec::new();
    host.feed(bytes, |event| events.push(event));
    events
}

/// Random bytes with a raised share of line characters.
pub(super) fn any_bytes() -> impl Strategy<Value = Vec<u8>> {
    let byte = prop_oneof![
        6 => prop::sample::select(b"0123456789ABCDEFabcdef".to_vec()),
        2 => prop::sample::select(b":;\r\n".to_vec()),
        1 => any::<u8>(),
    ];
    prop::collection::vec(byte, 0..200)
}

#[test]
fn the_published_lines_have_another_count_than_the_messages_here() {
    assert_eq!(
        device_events(&mut Device::default(), b":031F0001010203D7\r;05E000011A\r"),
        [
            DeviceEvent::Refused(Refusal::WrongCount(Message::SetVelocity)),
            DeviceEvent::Refused(Refusal::WrongCount(Message::Motion)),
        ]
    );
}

#[test]
fn a_good_line_may_still_be_refused() {
    let good = Payload::from_slice(&[0; 4]).unwrap();
    let write = |address, computer| Line::Write { address, computer, data: good };
    let read = |address, count| Line::Read { address, computer: COMPUTER_ID, count };
    for (line, refusal) in [
        (write(0x1F00, 2), Refusal::OtherComputer(2)),
        (write(0x1F04, COMPUTER_ID), Refusal::UnknownRegister(0x1F04)),
        (write(0xE000, COMPUTER_ID), Refusal::UnknownRegister(0xE000)),
        (read(0x1F00, 4), Refusal::UnknownRegister(0x1F00)),
        (read(0xE008, 7), Refusal::WrongCount(Message::Pose)),
        (write(0x1F10, COMPUTER_ID), Refusal::WrongCount(Message::WritePose)),
        (write(0x1F08, COMPUTER_ID), Refusal::WrongValue(Message::SetAcceleration)),
    ] {
        let mut device = Device::default();
        let events = device_events(&mut device, line.encode().as_slice());
        assert_eq!(events, [DeviceEvent::Refused(refusal)]);
    }
}

#[test]
fn a_published_host_loop_has_time_for_a_write_and_a_read() {
    let mut host = Host::default();
    let write = host
        .start(&Request::SetVelocity { drive: Default::default(), steer: Default::default() })
        .unwrap();
    assert_eq!(host_events(&mut host, &[0xDC]), [HostEvent::Written(Message::SetVelocity)]);
    let read = host.start(&Request::ReadMotion).unwrap();
    let characters = write.len() + 1 + read.len() + ANSWER_BYTES_MAX;
    assert_eq!(characters, 42);
    assert!(SETTINGS.time_for(characters) < Span::from_millis(27));
}

#[test]
fn one_exchange_at_a_time() {
    let mut host = Host::default();
    assert!(host.start(&Request::Stop).is_some());
    assert!(host.busy());
    assert_eq!(host.start(&Request::ReadMotion), None);
    assert_eq!(host.abandon(), Some(Message::Stop));
    assert_eq!(host.abandon(), None);
    assert!(host.start(&Request::ReadMotion).is_some());
    let counters = host.counters();
    assert_eq!((counters.started, counters.abandoned), (2, 1));
}

#[test]
fn a_stray_byte_costs_one_exchange_when_the_host_waits() {
    let (mut host, mut device) = (Host::default(), Device::default());
    let reply = Reply::Motion(Motion { sequence: 7, ..Motion::default() });
    let mut answer = |host: &mut Host| {
        let request = host.start(&Request::ReadMotion).unwrap();
        let events = device_events(&mut device, request.as_slice());
        let [DeviceEvent::Read(answer)] = events[..] else { panic!("{events:?}") };
        answer.packet(&reply).unwrap()
    };
    let first = answer(&mut host);
    let last = *first.as_slice().last().unwrap();
    let events = host_events(&mut host, &[&[0x55], first.as_slice()].concat());
    assert_eq!(events, [HostEvent::BadChecksum(Message::Motion), HostEvent::Unexpected(last)]);
    let second = answer(&mut host);
    assert_eq!(host_events(&mut host, second.as_slice()), [HostEvent::Reply(reply)]);
    assert!(quiet_time() >= SETTINGS.time_for(ANSWER_BYTES_MAX));
}

#[test]
fn an_answer_must_be_the_message_that_was_asked_for() {
    let line = Line::Read { address: 0xE008, computer: COMPUTER_ID, count: 8 };
    let events = device_events(&mut Device::default(), line.encode().as_slice());
    let [DeviceEvent::Read(answer)] = events[..] else { panic!("{events:?}") };
    assert_eq!(ReadAnswer::message(answer), Message::Pose);
    assert_eq!(answer.packet(&Reply::Motion(Motion::default())), None);
    // 08 E0 08 01 and eight zeros: the checksum is that of the request.
    let packet = answer.packet(&Reply::Pose(Pose::default())).unwrap();
    assert_eq!(packet.as_slice(), [0, 0, 0, 0, 0, 0, 0, 0, 0x0F]);
}

proptest! {
    #[test]
    fn both_ends_agree(request in any_request(), reply in any_reply()) {
        let (mut host, mut device) = (Host::default(), Device::default());
        let Some(packet) = host.start(&request) else {
            prop_assert_eq!(carried_request(&request), None);
            return Ok(());
        };
        let events = device_events(&mut device, packet.as_slice());
        match events[..] {
            [DeviceEvent::Write { request: came, answer }] => {
                prop_assert_eq!(Some(came), carried_request(&request));
                let events = host_events(&mut host, write_answer(answer).as_slice());
                prop_assert!(matches!(events[..], [HostEvent::Written(_)]), "{:?}", events);
            }
            [DeviceEvent::Read(answer)] => {
                let packet = answer.packet(&reply);
                let same = encode_reply(&reply).0 == answer.message();
                prop_assert_eq!(packet.is_some(), same);
                if let Some(packet) = packet {
                    let events = host_events(&mut host, packet.as_slice());
                    prop_assert_eq!(events, [HostEvent::Reply(carried_reply(&reply))]);
                }
            }
            _ => prop_assert!(false, "{:?}", events),
        }
    }

    #[test]
    fn every_line_begun_has_one_outcome(bytes in any_bytes()) {
        let mut device = Device::default();
        let events = device_events(&mut device, &bytes);
        let begun = bytes.iter().filter(|byte| matches!(byte, b':' | b';')).count();
        // The last one may still be incomplete.
        prop_assert!(events.len() == begun || events.len() + 1 == begun);
        let c = device.counters();
        let counted = c.writes + c.reads + c.malformed + c.bad_checksum + c.other_computer
            + c.unknown_register + c.wrong_count + c.wrong_value;
        prop_assert_eq!(counted, events.len() as u64);
        prop_assert!(c.skipped <= bytes.len() as u64);
    }

    #[test]
    fn a_changed_character_is_never_a_changed_request(
        request in any_request(), index: prop::sample::Index, bit in 0u32..8,
    ) {
        let Some(packet) = Host::default().start(&request) else { return Ok(()) };
        let mut bytes = packet.as_slice().to_vec();
        let index = index.index(bytes.len());
        bytes[index] ^= 1 << bit;
        let good = device_events(&mut Device::default(), packet.as_slice());
        for event in device_events(&mut Device::default(), &bytes) {
            // A flipped bit may turn a digit into the same digit in the other case.
            let refused = matches!(event, DeviceEvent::Refused(_));
            prop_assert!(refused || good == [event], "{:?} from {:?}", event, request);
        }
    }

    #[test]
    fn a_changed_bit_in_an_answer_is_found(
        reply in any_reply(), index in 0..ANSWER_BYTES_MAX, bit in 0u32..8,
    ) {
        let (mut host, mut device) = (Host::default(), Device::default());
        let read = match reply {
            Reply::Motion(_) => Request::ReadMotion,
            Reply::Pose(_) => Request::ReadPose,
        };
        let request = host.start(&read).unwrap();
        let events = device_events(&mut device, request.as_slice());
        let [DeviceEvent::Read(answer)] = events[..] else { panic!("{events:?}") };
        let mut bytes = answer.packet(&reply).unwrap().as_slice().to_vec();
        bytes[index] ^= 1 << bit;
        let events = host_events(&mut host, &bytes);
        prop_assert_eq!(events, [HostEvent::BadChecksum(answer.message())]);
        prop_assert!(!host.busy());
    }

    #[test]
    fn chunks_do_not_matter(
        bytes in any_bytes(), lines in prop::collection::vec(any_request(), 0..4), size in 1usize..9,
    ) {
        let mut stream = bytes.clone();
        for request in lines {
            if let Some(packet) = Host::default().start(&request) {
                stream.extend_from_slice(packet.as_slice());
            }
        }
        let whole = device_events(&mut Device::default(), &stream);
        let mut device = Device::default();
        let chunked: Vec<_> =
            stream.chunks(size).flat_map(|chunk| device_events(&mut device, chunk)).collect();
        prop_assert_eq!(whole, chunked);

        let (mut one, mut other) = (Host::default(), Host::default());
        prop_assert!(one.start(&Request::ReadPose).is_some());
        prop_assert!(other.start(&Request::ReadPose).is_some());
        let whole = host_events(&mut one, &bytes);
        let chunked: Vec<_> =
            bytes.chunks(size).flat_map(|chunk| host_events(&mut other, chunk)).collect();
        prop_assert_eq!(whole, chunked);
        prop_assert_eq!(one.counters(), other.counters());
    }
}
