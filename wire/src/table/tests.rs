//! The protocol's table, round trips and garbage.

use super::{
    Answer, AnswerDecoder, Command, CommandDecoder, LINE_BYTES_MAX, RESYNC_BYTES_MAX, Verb,
    parse_answer, parse_command,
};
use proptest::prelude::*;
use std::string::ToString;
use std::vec::Vec;

fn commands(decoder: &mut CommandDecoder, bytes: &[u8]) -> Vec<Result<Command, Answer>> {
    let mut found = Vec::new();
    decoder.feed(bytes, |command| found.push(command));
    found
}

fn answers(decoder: &mut AnswerDecoder, bytes: &[u8]) -> Vec<Answer> {
    let mut found = Vec::new();
    decoder.feed(bytes, |answer| found.push(answer));
    found
}

fn any_command() -> impl Strategy<Value = Command> {
    prop_oneof![
        any::<u32>().prop_map(Command::TopRate),
        any::<u32>().prop_map(Command::Ramp),
        any::<i32>().prop_map(Command::Distance),
        Just(Command::Go),
        Just(Command::Stop),
        Just(Command::State),
    ]
}

fn any_answer() -> impl Strategy<Value = Answer> {
    prop_oneof![
        prop::sample::select(Verb::ALL[..5].to_vec()).prop_map(Answer::Done),
        prop::option::of(b'!'..=b'~').prop_map(Answer::Refused),
        (any::<i32>(), any::<bool>())
            .prop_map(|(position_steps, moving)| Answer::State { position_steps, moving }),
    ]
}

/// Random bytes with a raised share of line characters.
fn any_bytes() -> impl Strategy<Value = Vec<u8>> {
    let byte = prop_oneof![
        8 => prop::sample::select(b"VADGS?=!PM 01-+".to_vec()),
        2 => prop::sample::select(b"\r\n".to_vec()),
        1 => any::<u8>(),
    ];
    prop::collection::vec(byte, 0..200)
}

#[test]
fn the_lines_of_the_table_in_the_documentation() {
    for (line, command) in [
        ("V2400", Command::TopRate(2_400)),
        ("A1200", Command::Ramp(1_200)),
        ("D-28800", Command::Distance(-28_800)),
        ("G", Command::Go),
        ("S", Command::Stop),
        ("?", Command::State),
    ] {
        assert_eq!(parse_command(line.as_bytes()), Some(command));
        assert_eq!(command.to_string(), line);
    }
    for (line, answer) in [
        ("=V", Answer::Done(Verb::TopRate)),
        ("=G", Answer::Done(Verb::Go)),
        ("!G", Answer::refused(Verb::Go)),
        ("!", Answer::Refused(None)),
        ("=P-28800 M0", Answer::State { position_steps: -28_800, moving: false }),
        ("=P0 M1", Answer::State { position_steps: 0, moving: true }),
    ] {
        assert_eq!(parse_answer(line.as_bytes()), Some(answer));
        assert_eq!(answer.to_string(), line);
    }
}

#[test]
fn anything_else_is_refused_by_its_first_letter() {
    let refused = |first| Err(Answer::Refused(first));
    for (bytes, expected) in [
        (&b"V\r"[..], &[refused(Some(b'V'))][..]),
        (b"V-1\r", &[refused(Some(b'V'))]),
        (b"V+1\r", &[refused(Some(b'V'))]),
        (b"V4294967296\r", &[refused(Some(b'V'))]),
        (b"D2147483648\r", &[refused(Some(b'D'))]),
        (b"D--1\r", &[refused(Some(b'D'))]),
        (b"D 1\r", &[refused(Some(b'D'))]),
        (b"D+1\r", &[Ok(Command::Distance(1))]),
        (b"G1\r", &[refused(Some(b'G'))]),
        (b"g\r", &[refused(Some(b'g'))]),
        (b"\x00\r", &[refused(None)]),
        (b"\xFFG\r", &[refused(None)]),
        (b"V00000000000002400\r", &[refused(Some(b'V'))]),
        (b"G\r\nS\r\n\r\r", &[Ok(Command::Go), Ok(Command::Stop)]),
    ] {
        let mut decoder = CommandDecoder::default();
        assert_eq!(commands(&mut decoder, bytes), expected, "{:?}", bytes.escape_ascii());
        let count = expected.iter().filter(|command| command.is_err()).count();
        assert_eq!(decoder.refused(), count as u64);
    }
}

#[test]
fn a_line_that_is_no_answer_is_counted() {
    for line in [&b"=?"[..], b"=X", b"=P M0", b"=P1 M2", b"=P1  M0", b"!GG", b"! ", b"V1", b"=P1"] {
        assert_eq!(parse_answer(line), None, "{:?}", line.escape_ascii());
    }
    let mut decoder = AnswerDecoder::default();
    assert_eq!(answers(&mut decoder, b"=P12345678901234567 M0\r=?\r=S\r").len(), 1);
    assert_eq!(decoder.malformed(), 2);
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
    fn the_first_line_after_a_carriage_return_is_understood(
        garbage in any_bytes(), command in any_command(), answer in any_answer(),
    ) {
        let stream = |line: &[u8]| {
            assert!(line.len() <= RESYNC_BYTES_MAX);
            [&garbage[..], b"\r", line].concat()
        };
        let found = commands(&mut CommandDecoder::default(), &stream(command.encode().as_slice()));
        prop_assert_eq!(found.last(), Some(&Ok(command)));
        let found = answers(&mut AnswerDecoder::default(), &stream(answer.encode().as_slice()));
        prop_assert_eq!(found.last(), Some(&answer));
    }

    #[test]
    fn every_line_has_one_outcome(bytes in any_bytes()) {
        let lines = bytes
            .split(|byte| *byte == b'\r')
            .rev()
            .skip(1)
            .filter(|line| line.iter().any(|byte| *byte != b'\n'))
            .count();
        let mut decoder = CommandDecoder::default();
        let found = commands(&mut decoder, &bytes);
        prop_assert_eq!(found.len(), lines);
        // A refusal can be sent and read like any other answer.
        for refusal in found.into_iter().filter_map(Result::err) {
            let answered = answers(&mut AnswerDecoder::default(), refusal.encode().as_slice());
            prop_assert_eq!(answered, [refusal]);
        }
        let mut decoder = AnswerDecoder::default();
        let found = answers(&mut decoder, &bytes);
        prop_assert_eq!(found.len() as u64 + decoder.malformed(), lines as u64);
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
}
