//! Lines of any register, good and bad.

use super::{Line, LineDecoder, LineError};
use crate::base::payload::{PAYLOAD_BYTES_MAX, Payload};
use crate::base::serial_link::tests::any_bytes;
use crate::base::serial_link::{COMPUTER_ID, LINE_BYTES_MAX, RESYNC_BYTES_MAX};
use proptest::prelude::*;
use std::vec::Vec;

fn decode(bytes: &[u8]) -> Vec<Result<Line, LineError>> {
    let mut decoder = LineDecoder::default();
    bytes.iter().filter_map(|byte| decoder.push(*byte)).collect()
}

fn any_line() -> impl Strategy<Value = Line> {
    let data = prop::collection::vec(any::<u8>(), 0..=PAYLOAD_BYTES_MAX);
    prop_oneof![
        (any::<u16>(), any::<u8>(), data).prop_map(|(address, computer, data)| {
            Line::Write { address, computer, data: Payload::from_slice(&data).unwrap() }
        }),
        (any::<u16>(), any::<u8>(), any::<u8>())
            .prop_map(|(address, computer, count)| { Line::Read { address, computer, count } }),
    ]
}

#[test]
fn the_published_lines() {
    let write = Line::Write {
        address: 0x1F00,
        computer: COMPUTER_ID,
        data: Payload::from_slice(&[1, 2, 3]).unwrap(),
    };
    assert_eq!(write.encode().as_slice(), b":031F0001010203D7\r");
    assert_eq!(write.checksum(), 0xD7);
    let read = Line::Read { address: 0xE000, computer: COMPUTER_ID, count: 5 };
    assert_eq!(read.encode().as_slice(), b";05E000011A\r");
    assert_eq!(decode(b":031F0001010203D7\r;05E000011A\r"), [Ok(write), Ok(read)]);
}

#[test]
fn a_line_that_is_not_understood_says_why() {
    use LineError::{BadChecksum, Malformed};
    for (bytes, expected) in [
        (&b";05E000011B\r"[..], &[Err(BadChecksum)][..]),
        (b";05e000011a\r", &[Ok(Line::Read { address: 0xE000, computer: 1, count: 5 })]),
        (b";05E0000:05E000", &[Err(Malformed)]),
        (b";05E00001 1A\r", &[Err(Malformed)]),
        (b";05E000011A0\r", &[Err(Malformed)]),
        (b";05E00001\r", &[Err(Malformed)]),
        (b";\r", &[Err(Malformed)]),
        (b";05E00001011A19\r", &[Err(Malformed)]),
        (b":041F0001010203D6\r", &[Err(Malformed)]),
        (b":FF1F00010102030405060708090A0B0C\r", &[Err(Malformed)]),
        (b"\r\n05E000011A\r", &[]),
    ] {
        assert_eq!(decode(bytes), expected, "{:?}", bytes.escape_ascii());
    }
}

proptest! {
    #[test]
    fn a_line_comes_back(line in any_line()) {
        let packet = line.encode();
        prop_assert!(packet.len() <= LINE_BYTES_MAX);
        prop_assert_eq!(decode(packet.as_slice()), [Ok(line)]);
    }

    #[test]
    fn the_first_line_after_garbage_is_understood(garbage in any_bytes(), line in any_line()) {
        let packet = line.encode();
        prop_assert!(packet.len() <= RESYNC_BYTES_MAX);
        let lines = decode(&[&garbage[..], packet.as_slice()].concat());
        prop_assert_eq!(lines.last(), Some(&Ok(line)));
    }
}
