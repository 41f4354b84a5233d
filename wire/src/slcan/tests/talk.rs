//! A host and an adapter in conversation, over a line that cuts anywhere.

use super::super::{Adapter, Answer, AnswerDecoder, BitRate, Command};
use super::any_frame;
use crate::can::{CanFrame, Id};
use crate::time::{Span, Timestamp};
use proptest::prelude::*;
use std::vec::Vec;

#[derive(Debug, Clone)]
enum Event {
    /// The host sends this.
    Host(CanFrame),
    /// Another node sends this.
    Bus(CanFrame),
    /// This many bytes reach the adapter.
    ToAdapter(usize),
    /// This many bytes reach the host.
    ToHost(usize),
}

fn any_event() -> impl Strategy<Value = Event> {
    prop_oneof![
        any_frame().prop_map(Event::Host),
        any_frame().prop_map(Event::Bus),
        (1usize..40).prop_map(Event::ToAdapter),
        (1usize..40).prop_map(Event::ToHost),
    ]
}

/// Both ends, and the bytes in transit between them.
#[derive(Default)]
struct Pair {
    adapter: Adapter,
    to_adapter: Vec<u8>,
    to_host: Vec<u8>,
    decoder: AnswerDecoder,
    on_bus: Vec<CanFrame>,
    answers: Vec<Answer>,
}

impl Pair {
    fn ask(&mut self, command: &Command) {
        self.to_adapter.extend_from_slice(command.encode().as_slice());
    }

    fn take_output(&mut self) {
        while let Some(packet) = self.adapter.transmit() {
            self.to_host.extend_from_slice(packet.as_slice());
        }
    }

    fn deliver_to_adapter(&mut self, bytes: usize) {
        let chunk: Vec<_> = self.to_adapter.drain(..bytes.min(self.to_adapter.len())).collect();
        self.adapter.receive(&chunk, |frame| {
            self.on_bus.push(frame);
            Ok(())
        });
        self.take_output();
    }

    fn deliver_to_host(&mut self, bytes: usize) {
        let chunk: Vec<_> = self.to_host.drain(..bytes.min(self.to_host.len())).collect();
        self.decoder.feed(&chunk, |answer| self.answers.push(answer));
    }

    fn flush(&mut self) {
        while !self.to_adapter.is_empty() || !self.to_host.is_empty() {
            self.deliver_to_adapter(40);
            self.deliver_to_host(40);
        }
    }
}

proptest! {
    #[test]
    fn every_frame_arrives_once_in_order_and_is_acknowledged(
        events in prop::collection::vec(any_event(), 0..80),
    ) {
        let mut pair = Pair::default();
        for command in
            [Command::BitRate(BitRate::Kbit500), Command::TimestampsOn, Command::Open]
        {
            pair.ask(&command);
        }
        pair.flush();
        prop_assert_eq!(&pair.answers[..], &[Answer::Done; 3]);
        pair.answers.clear();

        let mut now = Timestamp::ZERO;
        let (mut from_host, mut from_bus) = (Vec::new(), Vec::new());
        for event in &events {
            match event {
                Event::Host(frame) => {
                    from_host.push(*frame);
                    pair.ask(&Command::Transmit(*frame));
                }
                Event::Bus(frame) => {
                    now += Span::from_millis(7);
                    from_bus.push((*frame, 7 * (from_bus.len() as u16 + 1)));
                    pair.adapter.receive_frame(now, *frame);
                    pair.take_output();
                }
                Event::ToAdapter(bytes) => pair.deliver_to_adapter(*bytes),
                Event::ToHost(bytes) => pair.deliver_to_host(*bytes),
            }
        }
        pair.flush();

        prop_assert_eq!(&pair.on_bus, &from_host);
        let mut heard = Vec::new();
        let mut acknowledged = Vec::new();
        for answer in &pair.answers {
            match answer {
                Answer::Frame(received) => {
                    heard.push((received.frame, received.timestamp_ms.unwrap()));
                }
                other => acknowledged.push(*other),
            }
        }
        prop_assert_eq!(heard, from_bus);
        let expected: Vec<_> = from_host
            .iter()
            .map(|frame| match frame.id() {
                Id::Standard(_) => Answer::TakenStandard,
                Id::Extended(_) => Answer::TakenExtended,
            })
            .collect();
        prop_assert_eq!(acknowledged, expected);
        let counters = pair.adapter.counters();
        prop_assert_eq!(counters.refused + counters.frames_lost + counters.answers_lost, 0);
    }
}
