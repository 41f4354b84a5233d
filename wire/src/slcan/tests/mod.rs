//! The protocol's lines, streams of them, and an adapter in use.

mod adapter;
mod lines;
mod streams;
mod talk;

use super::{
    Answer, AnswerDecoder, BitRate, BitTiming, BusErrors, Command, CommandDecoder, LineError,
    ReceivedFrame, StateReport, StatusFlags, TEXT_BYTES_MAX, Text,
};
use crate::can::{CanFrame, ExtendedId, Id, StandardId};
use crate::can_error::{BusState, ErrorCounters};
use embedded_can::Frame as _;
use proptest::prelude::*;
use std::vec::Vec;

fn standard(id: u16, data: &[u8]) -> CanFrame {
    CanFrame::new(StandardId::new(id).unwrap(), data).unwrap()
}

fn extended(id: u32, data: &[u8]) -> CanFrame {
    CanFrame::new(ExtendedId::new(id).unwrap(), data).unwrap()
}

fn commands(decoder: &mut CommandDecoder, bytes: &[u8]) -> Vec<Result<Command, LineError>> {
    let mut found = Vec::new();
    decoder.feed(bytes, |command| found.push(command));
    found
}

fn answers(decoder: &mut AnswerDecoder, bytes: &[u8]) -> Vec<Answer> {
    let mut found = Vec::new();
    decoder.feed(bytes, |answer| found.push(answer));
    found
}

fn any_id() -> impl Strategy<Value = Id> {
    prop_oneof![
        (0u16..=0x7FF).prop_map(|raw| Id::Standard(StandardId::new(raw).unwrap())),
        (0u32..=0x1FFF_FFFF).prop_map(|raw| Id::Extended(ExtendedId::new(raw).unwrap())),
    ]
}

fn any_frame() -> impl Strategy<Value = CanFrame> {
    prop_oneof![
        3 => (any_id(), prop::collection::vec(any::<u8>(), 0..=8))
            .prop_map(|(id, data)| CanFrame::new(id, &data).unwrap()),
        1 => (any_id(), 0usize..=8).prop_map(|(id, dlc)| CanFrame::new_remote(id, dlc).unwrap()),
    ]
}

fn any_text() -> impl Strategy<Value = Text> {
    prop::collection::vec(b' '..=b'~', 0..=TEXT_BYTES_MAX)
        .prop_map(|text| Text::new(&text).unwrap())
}

fn any_command() -> impl Strategy<Value = Command> {
    prop_oneof![
        4 => any_frame().prop_map(Command::Transmit),
        1 => prop::sample::select(BitRate::ALL.to_vec()).prop_map(Command::BitRate),
        1 => any::<(u8, u8)>()
            .prop_map(|(btr0, btr1)| Command::BitTiming(BitTiming { btr0, btr1 })),
        2 => prop::sample::select(std::vec![
            Command::Open,
            Command::OpenListenOnly,
            Command::Close,
            Command::Version,
            Command::SerialNumber,
            Command::Status,
            Command::TimestampsOff,
            Command::TimestampsOn,
        ]),
    ]
}

fn any_state_report() -> impl Strategy<Value = StateReport> {
    let state = prop::sample::select(std::vec![
        BusState::Active,
        BusState::Warning,
        BusState::Passive,
        BusState::BusOff,
    ]);
    (state, 0u16..=999, 0u16..=999)
        .prop_map(|(state, tx, rx)| StateReport { state, counters: ErrorCounters { tx, rx } })
}

fn any_answer() -> impl Strategy<Value = Answer> {
    prop_oneof![
        4 => (any_frame(), prop::option::of(any::<u16>())).prop_map(|(frame, timestamp_ms)| {
            Answer::Frame(ReceivedFrame { frame, timestamp_ms })
        }),
        1 => prop::sample::select(std::vec![
            Answer::Done,
            Answer::Refused,
            Answer::TakenStandard,
            Answer::TakenExtended,
        ]),
        1 => any_text().prop_map(Answer::Version),
        1 => any_text().prop_map(Answer::SerialNumber),
        1 => any::<u8>().prop_map(|bits| Answer::Status(StatusFlags::from_bits_retain(bits))),
        1 => any_state_report().prop_map(Answer::State),
        1 => any::<u8>().prop_map(|bits| Answer::Errors(BusErrors::from_bits_retain(bits))),
    ]
}

/// Random bytes with a raised share of line characters.
fn any_bytes() -> impl Strategy<Value = Vec<u8>> {
    let byte = prop_oneof![
        8 => prop::sample::select(b"tTrRdDbBsSeOLCVNFzZ0123456789abcdefABF".to_vec()),
        2 => prop::sample::select(b"\r\x07\n".to_vec()),
        1 => any::<u8>(),
    ];
    prop_oneof![
        prop::collection::vec(byte, 0..200),
        // Lines of the protocol, cut anywhere.
        prop::collection::vec((any_answer(), 0usize..32), 0..10).prop_map(|lines| {
            lines
                .iter()
                .flat_map(|(line, cut)| {
                    let bytes = line.encode().as_slice().to_vec();
                    bytes.into_iter().take(*cut)
                })
                .collect()
        }),
    ]
}
