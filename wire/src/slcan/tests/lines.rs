//! Content and meaning of lines.

use super::super::{
    Answer, BitRate, BitTiming, BusErrors, Command, LineError, ReceivedFrame, StateReport,
    StatusFlags, Text, parse_answer, parse_command,
};
use super::{extended, standard};
use crate::can::{CanFrame, ExtendedId, StandardId};
use crate::can_error::{BusState, CanErrorEvent, ErrorCounters};
use embedded_can::Frame as _;
use std::fmt::Write as _;
use std::string::String;

#[test]
fn the_lines_of_a_host() {
    for (line, command) in [
        ("S0", Command::BitRate(BitRate::Kbit10)),
        ("S6", Command::BitRate(BitRate::Kbit500)),
        ("S8", Command::BitRate(BitRate::Mbit1)),
        ("s011C", Command::BitTiming(BitTiming { btr0: 0x01, btr1: 0x1C })),
        ("O", Command::Open),
        ("L", Command::OpenListenOnly),
        ("C", Command::Close),
        ("V", Command::Version),
        ("N", Command::SerialNumber),
        ("F", Command::Status),
        ("Z0", Command::TimestampsOff),
        ("Z1", Command::TimestampsOn),
        ("t1230", Command::Transmit(standard(0x123, &[]))),
        ("t4563112233", Command::Transmit(standard(0x456, &[0x11, 0x22, 0x33]))),
        ("T12ABCDEF2AA55", Command::Transmit(extended(0x12AB_CDEF, &[0xAA, 0x55]))),
        (
            "r1238",
            Command::Transmit(CanFrame::new_remote(StandardId::new(0x123).unwrap(), 8).unwrap()),
        ),
        ("R1FFFFFFF0", Command::Transmit(CanFrame::new_remote(ExtendedId::MAX, 0).unwrap())),
    ] {
        assert_eq!(parse_command(line.as_bytes()), Ok(command), "{line}");
        assert_eq!(command.encode().as_slice(), std::format!("{line}\r").as_bytes());
    }
    assert_eq!(parse_command(b"t7ff1aB"), Ok(Command::Transmit(standard(0x7FF, &[0xAB]))));
}

#[test]
fn the_lines_of_an_adapter() {
    let frame = |frame, timestamp_ms| Answer::Frame(ReceivedFrame { frame, timestamp_ms });
    let state =
        |state, rx, tx| Answer::State(StateReport { state, counters: ErrorCounters { tx, rx } });
    for (line, answer) in [
        ("", Answer::Done),
        ("z", Answer::TakenStandard),
        ("Z", Answer::TakenExtended),
        ("V1013", Answer::Version(Text::new(b"1013").unwrap())),
        ("NA123", Answer::SerialNumber(Text::new(b"A123").unwrap())),
        ("F00", Answer::Status(StatusFlags::empty())),
        (
            "FA1",
            Answer::Status(
                StatusFlags::RECEIVE_FIFO_FULL
                    | StatusFlags::ERROR_PASSIVE
                    | StatusFlags::BUS_ERROR,
            ),
        ),
        ("t1230", frame(standard(0x123, &[]), None)),
        ("t10021133A902", frame(standard(0x100, &[0x11, 0x33]), Some(43_266))),
        (
            "T1111222281122334455667788EA5F",
            frame(
                extended(0x1111_2222, &[0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88]),
                Some(59_999),
            ),
        ),
        ("sa057033", state(BusState::Active, 57, 33)),
        ("sw100000", state(BusState::Warning, 100, 0)),
        ("sp000130", state(BusState::Passive, 0, 130)),
        ("sb256256", state(BusState::BusOff, 256, 256)),
        ("e1a", Answer::Errors(BusErrors::ACKNOWLEDGEMENT)),
        ("e3bcO", Answer::Errors(BusErrors::BIT0 | BusErrors::CRC | BusErrors::TX_OVERRUN)),
        ("e0", Answer::Errors(BusErrors::empty())),
    ] {
        assert_eq!(parse_answer(line.as_bytes()), Ok(answer), "{line}");
        assert_eq!(answer.encode().as_slice(), std::format!("{line}\r").as_bytes());
    }
    assert_eq!(Answer::Refused.encode().as_slice(), b"\x07");
    // Letters in another order, with one repeated.
    let errors = Answer::Errors(BusErrors::BIT0 | BusErrors::CRC);
    assert_eq!(parse_answer(b"e3cbc"), Ok(errors));
}

#[test]
fn what_is_no_line() {
    for line in [
        "S",
        "S9",
        "S66",
        "s011",
        "s011C0",
        "s01G0",
        "OO",
        "o",
        "Z",
        "Z2",
        "F0",
        "V1",
        " V",
        "t",
        "t12",
        "t123",
        "t1231",
        "t12311",
        "t1231111",
        "t1239112233445566778899",
        "t123G",
        "t8000",
        "T200000000",
        "T12345678",
        "r12311",
        "r1239",
        "t1230EA5F",
    ] {
        assert_eq!(parse_command(line.as_bytes()), Err(LineError::Malformed), "{line}");
    }
    for line in [
        "zz",
        "O",
        "F",
        "F0",
        "F000",
        "FG0",
        "V\u{1}",
        "N\u{7f}",
        "t12",
        "t8000",
        "t12311",
        "t1230EA5",
        "t1230EA5G",
        "r12301",
        "sx000000",
        "s",
        "sa",
        "sa00000",
        "sa0000000",
        "sa00 000",
        "sa-01000",
        "e",
        "e1",
        "e1ab",
        "e1x",
        "e9",
        "ea",
    ] {
        assert_eq!(parse_answer(line.as_bytes()), Err(LineError::Malformed), "{line}");
    }
    assert_eq!(parse_answer(b"V\xFF"), Err(LineError::Malformed));
}

#[test]
fn frames_of_can_fd_are_unsupported_and_not_malformed() {
    for line in
        ["d1230", "D000001230", "b1232AABB", "B1FFFFFFF1AA", "d1230EA5F", "b1238AABBCCDDEEFF0011"]
    {
        assert_eq!(parse_command(line.as_bytes()), Err(LineError::Unsupported), "{line}");
        assert_eq!(parse_answer(line.as_bytes()), Err(LineError::Unsupported), "{line}");
    }
    for line in ["d", "d123", "dXYZ0", "d1231", "d12311", "b1232AABBC", "D1230", "d123G"] {
        assert_eq!(parse_answer(line.as_bytes()), Err(LineError::Malformed), "{line}");
    }
}

/// As Linux 6.1 converts them, except for the counters at bus-off, which it omits.
#[test]
fn reports_of_the_bus_as_error_frames() {
    let mut table = String::new();
    for line in [
        "sw100000", "sw000100", "sp130130", "sb000256", "sa000000", "e1a", "e1b", "e1B", "e1c",
        "e1f", "e1o", "e1O", "e1s", "e2ac", "e3bcO",
    ] {
        let event = match parse_answer(line.as_bytes()) {
            Ok(Answer::State(report)) => CanErrorEvent::from(report),
            Ok(Answer::Errors(errors)) => CanErrorEvent::from(errors),
            other => panic!("{line}: {other:?}"),
        };
        writeln!(table, "{line:9} {event}").unwrap();
    }
    insta::assert_snapshot!(table, @r"
    sw100000  error-warning (receive), counters tx 0 rx 100
    sw000100  error-warning (transmit), counters tx 100 rx 0
    sp130130  error-passive (transmit and receive), counters tx 130 rx 130
    sb000256  bus-off, counters tx 256 rx 0
    sa000000  error-active, counters tx 0 rx 0
    e1a       no acknowledgement, protocol violation at acknowledgement slot, bus error
    e1b       protocol violation (dominant bit not sent), bus error
    e1B       protocol violation (recessive bit not sent), bus error
    e1c       protocol violation (bit error) at checksum, bus error
    e1f       protocol violation (form error), bus error
    e1o       receive buffer overflow, protocol violation, bus error
    e1O       transmit buffer overflow, protocol violation, bus error
    e1s       protocol violation (stuff error), bus error
    e2ac      no acknowledgement, protocol violation (bit error) at checksum, bus error
    e3bcO     transmit buffer overflow, protocol violation (bit error, dominant bit not sent) at checksum, bus error
    ");
}
