//! Lines in streams of bytes, good and bad.

use super::super::{
    Answer, AnswerDecoder, CommandDecoder, FD_LINE_BYTES_MAX, LINE_BYTES_MAX, LOST_BYTES_MAX,
    LineError, ReceivedFrame,
};
use super::{answers, any_answer, any_bytes, any_command, any_frame, commands, standard};
use proptest::prelude::*;
use std::string::String;
use std::vec::Vec;

/// A line of a CAN FD frame, terminator included.
fn any_fd_line() -> impl Strategy<Value = Vec<u8>> {
    (
        prop::sample::select(b"dDbB".to_vec()),
        any::<[u8; 64]>(),
        0usize..16,
        prop::option::of(any::<u16>()),
    )
        .prop_map(|(letter, data, code, timestamp_ms)| {
            let bytes = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64][code];
            let id = if letter.is_ascii_lowercase() { "7A5" } else { "1ABCDEF0" };
            let mut line = std::format!("{}{id}{code:X}", char::from(letter));
            line.extend(data[..bytes].iter().map(|byte| std::format!("{byte:02X}")));
            line.extend(timestamp_ms.map(|timestamp_ms| std::format!("{timestamp_ms:04X}")));
            assert!(line.len() <= FD_LINE_BYTES_MAX);
            line.push('\r');
            line.into_bytes()
        })
}

#[test]
fn every_bell_is_an_answer_and_ends_a_line() {
    let mut decoder = AnswerDecoder::default();
    let found = answers(&mut decoder, b"\x07t12\x07\r\x07z\x07\n\r");
    use Answer::{Done, Refused, TakenStandard};
    assert_eq!(found, [Refused, Refused, Done, Refused, TakenStandard, Refused, Done]);
    assert_eq!(decoder.counters().malformed, 1);
    assert_eq!(decoder.counters().understood, 7);
}

#[test]
fn a_line_that_is_too_long_is_dropped_and_counted() {
    let good = standard(0x123, &[1]);
    let expected = Answer::Frame(ReceivedFrame { frame: good, timestamp_ms: None });
    for length in [LINE_BYTES_MAX + 1, FD_LINE_BYTES_MAX + 1, 100_000] {
        let mut bytes = std::vec![b't'; length];
        bytes.extend_from_slice(b"\rt123101\r");
        let mut decoder = AnswerDecoder::default();
        assert_eq!(answers(&mut decoder, &bytes), [expected]);
        assert_eq!(decoder.counters().overlong, 1);
        let mut decoder = CommandDecoder::default();
        let found = commands(&mut decoder, &bytes);
        assert_eq!(found[0], Err(LineError::Overlong));
        assert!(found[1].is_ok());
    }
    // The longest permitted length, but not a line.
    let mut decoder = AnswerDecoder::default();
    assert_eq!(answers(&mut decoder, String::from("t").repeat(LINE_BYTES_MAX).as_bytes()), []);
    assert_eq!(answers(&mut decoder, b"\r"), []);
    assert_eq!(decoder.counters().malformed, 1);
}

proptest! {
    #[test]
    fn commands_and_answers_come_back(command in any_command(), answer in any_answer()) {
        let packet = command.encode();
        prop_assert!(packet.len() <= LINE_BYTES_MAX + 1);
        prop_assert_eq!(commands(&mut CommandDecoder::default(), packet.as_slice()), [Ok(command)]);
        let packet = answer.encode();
        prop_assert!(packet.len() <= LINE_BYTES_MAX + 1);
        prop_assert_eq!(answers(&mut AnswerDecoder::default(), packet.as_slice()), [answer]);
    }

    #[test]
    fn the_first_line_after_a_terminator_is_understood(
        garbage in any_bytes(),
        terminator in prop::sample::select(b"\r\x07".to_vec()),
        command in any_command(),
        answer in any_answer(),
    ) {
        let stream = |line: &[u8]| [&garbage[..], &[terminator], line].concat();
        let found = commands(&mut CommandDecoder::default(), &stream(command.encode().as_slice()));
        prop_assert_eq!(found.last(), Some(&Ok(command)));
        let found = answers(&mut AnswerDecoder::default(), &stream(answer.encode().as_slice()));
        prop_assert_eq!(found.last(), Some(&answer));
    }

    #[test]
    fn every_line_has_one_outcome(bytes in any_bytes()) {
        let mut lines = 0;
        let mut bells = 0;
        let mut empty_at_bell = 0;
        let mut length = 0;
        for byte in &bytes {
            match byte {
                b'\r' => { lines += 1; length = 0; }
                0x07 => { bells += 1; empty_at_bell += u64::from(length == 0); length = 0; }
                b'\n' if length == 0 => {}
                _ => length += 1,
            }
        }
        let mut decoder = CommandDecoder::default();
        let found = commands(&mut decoder, &bytes).len() as u64;
        let counters = decoder.counters();
        let refused = counters.malformed + counters.overlong + counters.unsupported;
        prop_assert_eq!(found, counters.understood + refused);
        prop_assert_eq!(found, lines + bells - empty_at_bell);
        let mut decoder = AnswerDecoder::default();
        let found = answers(&mut decoder, &bytes).len() as u64;
        let counters = decoder.counters();
        prop_assert_eq!(found, counters.understood);
        let refused = counters.malformed + counters.overlong + counters.unsupported;
        prop_assert_eq!(found + refused, lines + 2 * bells - empty_at_bell);
    }

    #[test]
    fn chunks_do_not_matter(bytes in any_bytes(), size in 1usize..20) {
        let whole = commands(&mut CommandDecoder::default(), &bytes);
        let mut decoder = CommandDecoder::default();
        let chunked: Vec<_> =
            bytes.chunks(size).flat_map(|chunk| commands(&mut decoder, chunk)).collect();
        prop_assert_eq!(whole, chunked);
        let whole = answers(&mut AnswerDecoder::default(), &bytes);
        let mut decoder = AnswerDecoder::default();
        let chunked: Vec<_> =
            bytes.chunks(size).flat_map(|chunk| answers(&mut decoder, chunk)).collect();
        prop_assert_eq!(whole, chunked);
    }

    #[test]
    fn one_spoiled_byte_loses_two_lines_at_most(
        frames in prop::collection::vec((any_frame(), prop::option::of(any::<u16>())), 1..8),
        place in any::<prop::sample::Index>(),
        spoiled in any::<u8>(),
    ) {
        let sent: Vec<_> = frames
            .iter()
            .map(|(frame, timestamp_ms)| {
                Answer::Frame(ReceivedFrame { frame: *frame, timestamp_ms: *timestamp_ms })
            })
            .collect();
        let lines: Vec<_> = sent.iter().map(Answer::encode).collect();
        let mut bytes: Vec<u8> = lines.iter().flat_map(|line| line.as_slice().to_vec()).collect();
        let place = place.index(bytes.len());
        bytes[place] = spoiled;
        let mut end = 0;
        let hit = lines.iter().position(|line| { end += line.len(); place < end }).unwrap();
        // A changed terminator joins its line with the next; any other byte corrupts only its own line.
        let first_after = if place + 1 == end { hit + 2 } else { hit + 1 };
        let lost: usize = lines[hit..].iter().take(first_after - hit).map(|line| line.len()).sum();
        prop_assert!(lost <= LOST_BYTES_MAX);

        let found = answers(&mut AnswerDecoder::default(), &bytes);
        prop_assert_eq!(&found[..hit], &sent[..hit]);
        let after = sent.get(first_after..).unwrap_or_default();
        prop_assert_eq!(&found[found.len() - after.len()..], after);
    }

    #[test]
    fn can_fd_frames_are_passed_over(
        lines in prop::collection::vec(prop_oneof![
            any_fd_line().prop_map(|line| (line, None)),
            any_answer().prop_map(|answer| (answer.encode().as_slice().to_vec(), Some(answer))),
        ], 0..10),
    ) {
        let bytes = lines.iter().map(|(line, _)| &line[..]).collect::<Vec<_>>().concat();
        let expected: Vec<_> = lines.iter().filter_map(|(_, answer)| *answer).collect();
        let mut decoder = AnswerDecoder::default();
        prop_assert_eq!(answers(&mut decoder, &bytes), &expected[..]);
        let unsupported = (lines.len() - expected.len()) as u64;
        prop_assert_eq!(decoder.counters().unsupported, unsupported);
        prop_assert_eq!(decoder.counters().malformed + decoder.counters().overlong, 0);
    }
}
