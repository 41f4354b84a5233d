//! Descriptions of error frames.

use super::{
    CanErrorEvent, ControllerProblems, ERROR_FLAG, ErrorCounters, ProtocolErrors, ProtocolLocation,
    ProtocolViolation, Transceiver,
};
use insta::assert_snapshot;
use proptest::prelude::*;
use std::fmt::Write as _;
use std::string::{String, ToString as _};

/// Identifier and data of error frames, every class alone and some together.
const FRAMES: [(u32, [u8; 8]); 24] = [
    (0x001, [0; 8]),
    (0x002, [0; 8]),
    (0x002, [11, 0, 0, 0, 0, 0, 0, 0]),
    (0x004, [0; 8]),
    (0x004, [0, 0x01, 0, 0, 0, 0, 0, 0]),
    (0x004, [0, 0x02, 0, 0, 0, 0, 0, 0]),
    (0x204, [0, 0x08, 0, 0, 0, 0, 96, 0]),
    (0x204, [0, 0x04, 0, 0, 0, 0, 0, 97]),
    (0x204, [0, 0x20, 0, 0, 0, 0, 128, 0]),
    (0x204, [0, 0x30, 0, 0, 0, 0, 130, 130]),
    (0x204, [0, 0x40, 0, 0, 0, 0, 12, 0]),
    (0x008, [0; 8]),
    (0x088, [0, 0, 0x04, 0x0A, 0, 0, 0, 0]),
    (0x088, [0, 0, 0x88, 0x0B, 0, 0, 0, 0]),
    (0x088, [0, 0, 0x02, 0x77, 0, 0, 0, 0]),
    (0x0A8, [0, 0, 0, 0x19, 0, 0, 0, 0]),
    (0x010, [0; 8]),
    (0x010, [0, 0, 0, 0, 0x04, 0, 0, 0]),
    (0x010, [0, 0, 0, 0, 0x87, 0, 0, 0]),
    (0x040, [0; 8]),
    (0x100, [0; 8]),
    (0x200, [0, 0, 0, 0, 0, 0, 3, 255]),
    (0x400, [0; 8]),
    (0x000, [0; 8]),
];

#[test]
fn error_frames_in_words() {
    let mut table = String::new();
    for (id, data) in FRAMES {
        let event = CanErrorEvent::decode(id, &data);
        let state = event.bus_state().map_or(String::new(), |state| state.to_string());
        writeln!(table, "{id:03X} {data:02X?} | {state:13} | {event}").unwrap();
    }
    assert_snapshot!(table, @r"
    001 [00, 00, 00, 00, 00, 00, 00, 00] |               | transmit timeout
    002 [00, 00, 00, 00, 00, 00, 00, 00] |               | lost arbitration
    002 [0B, 00, 00, 00, 00, 00, 00, 00] |               | lost arbitration in bit 11
    004 [00, 00, 00, 00, 00, 00, 00, 00] |               | controller problem
    004 [00, 01, 00, 00, 00, 00, 00, 00] |               | receive buffer overflow
    004 [00, 02, 00, 00, 00, 00, 00, 00] |               | transmit buffer overflow
    204 [00, 08, 00, 00, 00, 00, 60, 00] | error-warning | error-warning (transmit), counters tx 96 rx 0
    204 [00, 04, 00, 00, 00, 00, 00, 61] | error-warning | error-warning (receive), counters tx 0 rx 97
    204 [00, 20, 00, 00, 00, 00, 80, 00] | error-passive | error-passive (transmit), counters tx 128 rx 0
    204 [00, 30, 00, 00, 00, 00, 82, 82] | error-passive | error-passive (transmit and receive), counters tx 130 rx 130
    204 [00, 40, 00, 00, 00, 00, 0C, 00] | error-active  | error-active, counters tx 12 rx 0
    008 [00, 00, 00, 00, 00, 00, 00, 00] |               | protocol violation
    088 [00, 00, 04, 0A, 00, 00, 00, 00] |               | protocol violation (stuff error) at data, bus error
    088 [00, 00, 88, 0B, 00, 00, 00, 00] |               | protocol violation (dominant bit not sent, while sending) at data length code, bus error
    088 [00, 00, 02, 77, 00, 00, 00, 00] |               | protocol violation (form error) at location 0x77, bus error
    0A8 [00, 00, 00, 19, 00, 00, 00, 00] |               | no acknowledgement, protocol violation at acknowledgement slot, bus error
    010 [00, 00, 00, 00, 00, 00, 00, 00] |               | transceiver fault
    010 [00, 00, 00, 00, 04, 00, 00, 00] |               | transceiver fault (CANH: no wire)
    010 [00, 00, 00, 00, 87, 00, 00, 00] |               | transceiver fault (CANH: short circuit to ground) (CANL: short circuit to CANH)
    040 [00, 00, 00, 00, 00, 00, 00, 00] | bus-off       | bus-off
    100 [00, 00, 00, 00, 00, 00, 00, 00] | error-active  | restarted
    200 [00, 00, 00, 00, 00, 00, 03, FF] |               | counters tx 3 rx 255
    400 [00, 00, 00, 00, 00, 00, 00, 00] |               | unknown class 0x400
    000 [00, 00, 00, 00, 00, 00, 00, 00] |               | nothing reported
    ");
}

#[test]
fn missing_data_are_zero() {
    let event = CanErrorEvent::decode(0x3FF, &[3]);
    assert_eq!(event, CanErrorEvent::decode(0x3FF, &[3, 0, 0, 0, 0, 0, 0, 0]));
    assert_eq!(event.lost_arbitration, Some(3));
}

#[test]
fn every_byte_goes_to_its_field() {
    let event = CanErrorEvent::decode(ERROR_FLAG | 0x1000_03FF, &[1, 2, 3, 4, 5, 6, 7, 8]);
    let expected = CanErrorEvent {
        tx_timeout: true,
        lost_arbitration: Some(1),
        controller: Some(ControllerProblems::from_bits_retain(2)),
        protocol: Some(ProtocolViolation {
            errors: ProtocolErrors::from_bits_retain(3),
            location: ProtocolLocation(4),
        }),
        transceiver: Some(Transceiver(5)),
        no_acknowledgement: true,
        bus_off: true,
        bus_error: true,
        restarted: true,
        counters: Some(ErrorCounters { tx: 7, rx: 8 }),
        unknown_classes: 0x1000_0000,
    };
    assert_eq!(event, expected);
}

proptest! {
    #[test]
    fn whatever_an_error_frame_holds_has_words(id in any::<u32>(), data in any::<[u8; 8]>()) {
        let event = CanErrorEvent::decode(id, &data);
        prop_assert_eq!(event, CanErrorEvent::decode(id & !ERROR_FLAG, &data));
        prop_assert!(!event.to_string().is_empty());
    }
}
