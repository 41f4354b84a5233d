//! An adapter's answers, flags and bounds.

use super::super::{
    Adapter, Answer, AnswerDecoder, BitRate, Channel, OUTPUT_LINES_MAX, StatusFlags, TransmitFull,
};
use super::{any_bytes, any_frame, extended, standard};
use crate::can::CanFrame;
use crate::packet::BYTES_MAX;
use crate::time::{Span, Timestamp};
use proptest::prelude::*;
use std::string::{String, ToString as _};
use std::vec::Vec;

fn output(adapter: &mut Adapter) -> String {
    let mut bytes = Vec::new();
    while let Some(packet) = adapter.transmit() {
        bytes.extend_from_slice(packet.as_slice());
    }
    bytes.escape_ascii().to_string()
}

/// The adapter's answer to `line`, on a bus with room.
fn ask(adapter: &mut Adapter, line: &str) -> String {
    adapter.receive(line.as_bytes(), |_| Ok(()));
    adapter.receive(b"\r", |_| Ok(()));
    output(adapter)
}

fn open() -> Adapter {
    let mut adapter = Adapter::default();
    assert_eq!(ask(&mut adapter, "S6\rO"), r"\r\r");
    adapter
}

const OK: &str = r"\r";
const REFUSED: &str = r"\x07";

#[test]
fn a_session() {
    let mut adapter = Adapter::default();
    for (line, answer) in [
        // Closed, and without a bit rate.
        ("V", r"V1013\r"),
        ("N", r"NA123\r"),
        ("O", REFUSED),
        ("L", REFUSED),
        ("C", REFUSED),
        ("F", REFUSED),
        ("t1230", REFUSED),
        ("S9", REFUSED),
        ("S6", OK),
        ("Z1", OK),
        ("Z0", OK),
        // Open.
        ("O", OK),
        ("O", REFUSED),
        ("L", REFUSED),
        ("S4", REFUSED),
        ("s011C", REFUSED),
        ("Z1", REFUSED),
        ("V", r"V1013\r"),
        ("F", r"F00\r"),
        ("t1230", r"z\r"),
        ("T000001230", r"Z\r"),
        ("r1238", r"z\r"),
        ("R1FFFFFFF0", r"Z\r"),
        ("t12", REFUSED),
        ("d1230", REFUSED),
        ("M00000000", REFUSED),
        ("", REFUSED),
        ("C", OK),
        // Closed again, with a bit rate.
        ("t1230", REFUSED),
        ("L", OK),
        // Listen-only.
        ("t1230", REFUSED),
        ("S4", REFUSED),
        ("F", r"F00\r"),
        ("C", OK),
        ("s031C", OK),
        ("O", OK),
    ] {
        assert_eq!(ask(&mut adapter, line), answer, "{line}");
    }
    assert_eq!(adapter.channel(), Channel::Open);
    assert_eq!(adapter.bits_per_second(), Some(BitRate::Kbit125.bits_per_second()));
    let counters = adapter.counters();
    assert_eq!((counters.frames_to_bus, counters.refused), (4, 18));
    // The empty line flushes, as each session of a host begins.
    assert_eq!((counters.lines.malformed, counters.lines.unsupported), (3, 1));
}

#[test]
fn frames_from_the_bus_come_while_it_is_heard() {
    let mut adapter = Adapter::default();
    let now = Timestamp::ZERO + Span::from_millis(61_234);
    let frame = standard(0x123, &[0xAB]);
    adapter.receive_frame(now, frame);
    assert_eq!(output(&mut adapter), "");
    assert_eq!(adapter.counters().frames_unheard, 1);
    for opening in ["O", "L"] {
        assert_eq!(ask(&mut adapter, "S6\rZ0"), r"\r\r");
        assert_eq!(ask(&mut adapter, opening), OK);
        adapter.receive_frame(now, frame);
        adapter.receive_frame(now, extended(0x123, &[]));
        assert_eq!(output(&mut adapter), r"t1231AB\rT000001230\r");
        assert_eq!(ask(&mut adapter, "C\rZ1"), r"\r\r");
        assert_eq!(ask(&mut adapter, opening), OK);
        // The clock has wrapped after a minute: 1,234 ms.
        adapter.receive_frame(now, frame);
        assert_eq!(output(&mut adapter), r"t1231AB04D2\r");
        assert_eq!(ask(&mut adapter, "C"), OK);
    }
    assert_eq!(adapter.counters().frames_to_host, 6);
}

#[test]
fn a_host_that_does_not_read_loses_frames_and_is_told() {
    let mut adapter = open();
    let sent = 2 * OUTPUT_LINES_MAX as u16;
    for id in 0..sent {
        adapter.receive_frame(Timestamp::ZERO, standard(id, &[]));
    }
    let lost = adapter.counters().frames_lost;
    assert_eq!(lost + adapter.counters().frames_to_host, u64::from(sent));
    assert!(lost > 0);
    // Its command is still answered, after the frames that had room.
    let answered = ask(&mut adapter, "F");
    assert!(answered.starts_with(r"t0000\rt0010\r"), "{answered}");
    assert!(answered.ends_with(r"F01\r"), "{answered}");
    assert_eq!(answered.matches('t').count() as u64, u64::from(sent) - lost);
    assert_eq!(ask(&mut adapter, "F"), r"F00\r");
    assert_eq!(adapter.counters().answers_lost, 0);
}

#[test]
fn a_bus_without_room_refuses_and_is_shown() {
    let mut adapter = open();
    adapter.receive(b"t1230\r", |_| Err(TransmitFull));
    assert_eq!(output(&mut adapter), REFUSED);
    assert_eq!(adapter.status(), StatusFlags::TRANSMIT_FIFO_FULL);
    assert_eq!(ask(&mut adapter, "F"), r"F02\r");
    assert_eq!(adapter.counters().frames_to_bus, 0);
}

#[test]
fn a_packet_of_commands_is_answered_whole_behind_a_full_queue() {
    let mut adapter = open();
    for id in 0..100 {
        adapter.receive_frame(Timestamp::ZERO, standard(id, &[]));
    }
    adapter.receive(&[b'\r'; BYTES_MAX], |_| Ok(()));
    assert_eq!(adapter.counters().answers_lost, 0);
    assert_eq!(output(&mut adapter).matches(REFUSED).count(), BYTES_MAX);
    // A longer run without a reader: the excess is counted.
    adapter.receive(&[b'\r'; OUTPUT_LINES_MAX + 5], |_| Ok(()));
    assert_eq!(adapter.counters().answers_lost, 5);
    assert_eq!(output(&mut adapter).matches(REFUSED).count(), OUTPUT_LINES_MAX);
}

#[derive(Debug, Clone)]
enum Input {
    Host(Vec<u8>),
    Frame(CanFrame),
    Read,
}

fn any_input() -> impl Strategy<Value = Input> {
    prop_oneof![
        any_bytes().prop_map(Input::Host),
        any_frame().prop_map(Input::Frame),
        Just(Input::Host(b"\rS6\rO\r".to_vec())),
        Just(Input::Read),
    ]
}

proptest! {
    #[test]
    fn whatever_comes_the_output_is_bounded_and_the_host_understands_it(
        inputs in prop::collection::vec(any_input(), 0..60),
        nanos in any::<i64>(),
    ) {
        let mut adapter = Adapter::default();
        let mut decoder = AnswerDecoder::default();
        let (mut sent, mut frames, mut answers) = (0, 0, 0);
        let mut read = |adapter: &mut Adapter| {
            let mut lines = 0;
            while let Some(packet) = adapter.transmit() {
                lines += 1;
                decoder.feed(packet.as_slice(), |answer| match answer {
                    Answer::Frame(_) => frames += 1,
                    _ => answers += 1,
                });
            }
            lines
        };
        for input in &inputs {
            match input {
                Input::Host(bytes) => adapter.receive(bytes, |_| { sent += 1; Ok(()) }),
                Input::Frame(frame) => {
                    adapter.receive_frame(Timestamp::from_nanos(nanos), *frame);
                }
                Input::Read => prop_assert!(read(&mut adapter) <= OUTPUT_LINES_MAX),
            }
        }
        prop_assert!(read(&mut adapter) <= OUTPUT_LINES_MAX);
        let counters = adapter.counters();
        prop_assert_eq!(counters.frames_to_bus, sent);
        prop_assert_eq!(counters.frames_to_host, frames);
        let understood = decoder.counters();
        prop_assert_eq!(understood.understood, frames + answers);
        prop_assert_eq!(understood.malformed + understood.overlong + understood.unsupported, 0);
    }
}
