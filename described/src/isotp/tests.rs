//! Two ends of a channel: messages arrive complete, and what goes wrong is noticed in time.

use super::{BYTES_MAX, Channel, End, IsoTp, Received, Slowness};
use crate::IsoTpTable;
use proptest::prelude::*;
use wire::can::{CanFrame, FdFlags, Id, StandardId};
use wire::time::{Span, Timestamp};

fn settings(more: &str) -> IsoTp {
    let table: IsoTpTable =
        toml::from_str(&format!("request_id = 0x7E0\nresponse_id = 0x7E8\n{more}")).unwrap();
    IsoTp::new(&table).unwrap()
}

fn at_ms(ms: i64) -> Timestamp {
    Timestamp::ZERO + Span::from_millis(ms)
}

/// A client and a server.
struct Pair {
    ends: [Channel; 2],
    now: Timestamp,
    /// Every frame, with its sender and time.
    frames: Vec<(Timestamp, usize, CanFrame)>,
    /// Numbers of the frames that are lost, and of those that come twice.
    lost: Vec<usize>,
    doubled: Vec<usize>,
}

impl Pair {
    fn new(more: &str) -> Self {
        let settings = settings(more);
        let ends = [End::Client, End::Server].map(|end| Channel::new(settings.clone(), end));
        let now = Timestamp::ZERO;
        Self { ends, now, frames: Vec::new(), lost: Vec::new(), doubled: Vec::new() }
    }

    /// Carries frames until nothing is left to do; returns what each end received.
    fn run(&mut self) -> [Vec<Received>; 2] {
        let mut received = [Vec::new(), Vec::new()];
        loop {
            let mut any = false;
            for from in 0..2 {
                while let Some(frame) = self.ends[from].transmit() {
                    any = true;
                    let number = self.frames.len();
                    self.frames.push((self.now, from, frame));
                    let times = 1 + usize::from(self.doubled.contains(&number))
                        - usize::from(self.lost.contains(&number));
                    for _ in 0..times {
                        received[1 - from].extend(self.ends[1 - from].receive(self.now, &frame));
                    }
                }
            }
            if any {
                continue;
            }
            let next = self.ends.iter().map(Channel::next_wakeup).min().unwrap();
            if next == Timestamp::MAX {
                return received;
            }
            self.now = self.now.max(next);
            self.ends.iter_mut().for_each(|end| end.wake(self.now));
        }
    }
}

fn message(length: usize) -> Vec<u8> {
    (0..length).map(|place| (place * 7 % 251) as u8).collect()
}

#[test]
fn the_frames_are_those_of_the_standard() {
    let mut pair = Pair::new("padding = 0xCC\nblock_size = 2");
    assert!(pair.ends[0].send(pair.now, &message(22)));
    let [_, server] = pair.run();
    assert_eq!(server, [Received { data: message(22), functional: false }]);
    let bytes: Vec<_> =
        pair.frames.iter().map(|(_, from, frame)| (*from, frame.data().to_vec())).collect();
    let data = message(22);
    let cf = |number: u8, part: &[u8]| {
        let mut frame = [&[0x20 | number], part].concat();
        frame.resize(8, 0xCC);
        (0, frame)
    };
    assert_eq!(
        bytes,
        [
            (0, [&[0x10, 22], &data[..6]].concat()),
            (1, vec![0x30, 2, 0, 0xCC, 0xCC, 0xCC, 0xCC, 0xCC]),
            cf(1, &data[6..13]),
            cf(2, &data[13..20]),
            (1, vec![0x30, 2, 0, 0xCC, 0xCC, 0xCC, 0xCC, 0xCC]),
            cf(3, &data[20..]),
        ]
    );
}

#[test]
fn frames_keep_the_separation_that_the_receiver_asks_for() {
    let mut pair = Pair::new("st_min_s = 0.005");
    pair.ends[0].send(pair.now, &message(27));
    pair.run();
    let times = pair.frames.iter().filter(|(_, from, _)| *from == 0).map(|(at, ..)| *at);
    assert_eq!(times.collect::<Vec<_>>(), [0, 0, 5, 10].map(at_ms));
}

#[test]
fn a_sender_gives_up_without_a_flow_control() {
    let mut pair = Pair::new("n_bs_s = 0.3");
    pair.lost = vec![1];
    pair.ends[0].send(pair.now, &message(20));
    pair.run();
    // The receiver, too, gives up: at N_Cr.
    assert_eq!(pair.ends[0].failure(), Some("no flow control within N_Bs"));
    assert_eq!(pair.ends[1].failure(), Some("no consecutive frame within N_Cr"));
    assert_eq!(pair.now, at_ms(1000));
    let mut late = Pair::new("n_bs_s = 0.3");
    let slow = Span::from_millis(400);
    late.ends[1].slowness = Slowness { flow_control: slow, separation: Span::ZERO };
    late.ends[0].send(late.now, &message(20));
    let [_, server] = late.run();
    assert!(server.is_empty());
    assert_eq!(late.ends[0].failure(), Some("no flow control within N_Bs"));
}

#[test]
fn a_lost_or_doubled_consecutive_frame_ends_a_message() {
    for doubled in [false, true] {
        let mut pair = Pair::new("");
        match doubled {
            true => pair.doubled = vec![3],
            false => pair.lost = vec![3],
        }
        pair.ends[0].send(pair.now, &message(40));
        let [_, server] = pair.run();
        assert!(server.is_empty());
        assert_eq!(pair.ends[1].failure(), Some("a consecutive frame out of sequence"));
    }
}

#[test]
fn what_is_too_long_is_refused() {
    let mut pair = Pair::new("");
    assert!(!pair.ends[0].send(pair.now, &message(BYTES_MAX + 1)));
    assert!(!pair.ends[0].send(pair.now, &[]));
    let id = Id::Standard(StandardId::new(0x7E0).unwrap());
    let first = CanFrame::new(id, &[0x10, 0, 0, 1, 0, 0, 1, 2]).unwrap();
    assert_eq!(pair.ends[1].receive(pair.now, &first), None);
    assert_eq!(pair.ends[1].transmit().unwrap().data(), [0x32, 0, 0]);
}

/// A first frame of what a single frame has room for.
#[test]
fn a_first_frame_of_seven_bytes_is_ignored() {
    for (length, answers) in [(7, 0), (8, 1)] {
        let mut pair = Pair::new("");
        let id = Id::Standard(StandardId::new(0x7E0).unwrap());
        let first = CanFrame::new(id, &[0x10, length, 1, 2, 3, 4, 5, 6]).unwrap();
        assert_eq!(pair.ends[1].receive(pair.now, &first), None);
        assert_eq!(std::iter::from_fn(|| pair.ends[1].transmit()).count(), answers, "{length}");
    }
}

#[test]
fn a_request_to_all_is_a_single_frame() {
    let mut pair = Pair::new("");
    assert!(pair.ends[0].send_to_all(&[0x3E, 0]));
    assert!(!pair.ends[0].send_to_all(&message(8)));
    let [_, server] = pair.run();
    assert_eq!(server, [Received { data: vec![0x3E, 0], functional: true }]);
}

proptest! {
    #[test]
    fn a_message_of_any_length_arrives(
        length in 1..=BYTES_MAX,
        fd in prop::option::of(prop::sample::select(vec![8u8, 12, 16, 20, 24, 32, 48, 64])),
        padding in prop::option::of(any::<u8>()),
        block_size in any::<u8>(),
    ) {
        let mut more = format!("block_size = {block_size}\n");
        more += &fd.map(|fd| format!("fd = {fd}\n")).unwrap_or_default();
        more += &padding.map(|padding| format!("padding = {padding}\n")).unwrap_or_default();
        let mut pair = Pair::new(&more);
        prop_assert!(pair.ends[0].send(pair.now, &message(length)));
        let [client, server] = pair.run();
        prop_assert!(client.is_empty());
        prop_assert_eq!(server, [Received { data: message(length), functional: false }]);
    }

    #[test]
    fn no_frames_cause_a_panic_and_nothing_grows(
        frames in prop::collection::vec((prop::sample::select(vec![0x7E0, 0x7DF, 0x7E8]), prop::collection::vec(any::<u8>(), 0..=64), 0..2000i64), 0..200),
    ) {
        let mut end = Channel::new(settings("fd = 64"), End::Server);
        let mut now = Timestamp::ZERO;
        for (id, data, later) in frames {
            now += Span::from_millis(later);
            let id = StandardId::new(id).unwrap();
            let frame = CanFrame::new(id, &data).or_else(|| CanFrame::fd(id, FdFlags::default(), &data));
            if let Some(received) = frame.and_then(|frame| end.receive(now, &frame)) {
                prop_assert!(received.data.len() <= BYTES_MAX);
                end.send(now, &received.data);
            }
            end.wake(now);
            while end.transmit().is_some() {}
        }
    }
}

#[test]
fn mistakes_are_named_with_their_keys() {
    let mistake = |text: &str| {
        let table: IsoTpTable = toml::from_str(text).unwrap();
        IsoTp::new(&table).unwrap_err().0
    };
    assert_eq!(mistake("request_id = 0x7E0"), "response_id");
    assert_eq!(mistake("request_id = 0x7E0\nresponse_id = 0x7E0"), "response_id");
    assert_eq!(mistake("request_id = 0x20000000\nresponse_id = 0x7E8"), "request_id");
    assert_eq!(mistake("request_id = 0x7E0\nresponse_id = 0x7E8\nfd = 10"), "fd");
    assert_eq!(mistake("request_id = 0x7E0\nresponse_id = 0x7E8F"), "response_id");
    assert_eq!(mistake("request_id = 1\nresponse_id = 2\nst_min_s = 0.0015"), "st_min_s");
    assert_eq!(mistake("request_id = 1\nnormal_fixed = { server = 1, tester = 2 }"), "request_id");
    let fixed: IsoTpTable =
        toml::from_str("normal_fixed = { server = 0x10, tester = 0xF1 }").unwrap();
    let fixed = IsoTp::new(&fixed).unwrap();
    let ids = [Some(fixed.request), Some(fixed.response), fixed.functional];
    let raw = ids.map(|id| wire::can::word(id.unwrap()) & !wire::can::EXTENDED_FLAG);
    assert_eq!(raw, [0x18DA_10F1, 0x18DA_F110, 0x18DB_33F1]);
}
