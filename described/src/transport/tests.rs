//! Two nodes and a listener: messages arrive complete by both methods, and losses are detected.

use crate::layout::{Decoder, Encoded, Encoder, Layout, Sender};
use crate::transport::Transport;
use proptest::prelude::*;
use wire::can::CanFrame;
use wire::j1939::{self, Identifier};
use wire::time::{Span, Timestamp};

/// The engine, address 0, broadcasts its fault codes (DM1, group 65226), and the display, address 40, a text.
const DBC: &str = r#"
BU_: Engine Display
BO_ 2566834942 Dm1: 20 Engine
 SG_ Lamp : 0|8@1+ (1,0) [0|255] "" Display
 SG_ Last : 152|8@1+ (1,0) [0|255] "" Display
BO_ 2566848766 Text: 1785 Engine
 SG_ First : 0|16@1+ (1,0) [0|65535] "" Display
 SG_ End : 14264|16@1+ (1,0) [0|65535] "" Display
BO_ 2364540158 Speed: 8 Engine
 SG_ Rpm : 24|16@1+ (0.125,0) [0|8031.875] "rpm" Display
BO_ 2565799976 Answer: 9 Display
 SG_ Key : 64|8@1+ (1,0) [0|255] "" Engine
BA_DEF_ BO_ "VFrameFormat" ENUM "StandardCAN","ExtendedCAN","reserved","J1939PG";
BA_DEF_ BU_ "NmStationAddress" INT 0 255;
BA_DEF_DEF_ "VFrameFormat" "J1939PG";
BA_DEF_DEF_ "NmStationAddress" 254;
BA_ "NmStationAddress" BU_ Engine 0;
BA_ "NmStationAddress" BU_ Display 40;
"#;

fn layout(node: &str) -> Layout {
    Layout::from_dbc("engine.dbc", DBC, node).unwrap()
}

fn at_ms(ms: i64) -> Timestamp {
    Timestamp::ZERO + Span::from_millis(ms)
}

/// The engine, the display, and a listener to the engine.
struct Bus {
    nodes: [Box<Transport>; 2],
    encoders: [Encoder; 2],
    ear: Decoder,
    now: Timestamp,
    /// Numbers of the frames that are lost.
    lost: Vec<usize>,
    frames: Vec<(Timestamp, CanFrame)>,
    heard: Vec<(Timestamp, String, Vec<Option<f64>>)>,
}

impl Bus {
    fn new() -> Self {
        let layouts = ["Engine", "Display"].map(layout);
        Self {
            nodes: layouts
                .each_ref()
                .map(|of| Box::new(Transport::new(of.addresses(Sender::Device).unwrap()))),
            encoders: layouts.each_ref().map(|of| Encoder::new(of.clone())),
            ear: layouts[0].decoder(),
            now: Timestamp::ZERO,
            lost: Vec::new(),
            frames: Vec::new(),
            heard: Vec::new(),
        }
    }

    fn send(&mut self, node: usize, message: &str, values: &[f64]) {
        let encoder = &mut self.encoders[node];
        let message = encoder.layout().find(message).unwrap();
        let encoded = encoder.encode(message, values, |_| false).unwrap();
        let Encoded::InParts(parts) = encoded else { panic!("in parts") };
        self.nodes[node].send(self.now, parts);
    }

    /// Frames take no time here.
    fn run(&mut self, until: Timestamp) {
        loop {
            while let Some((node, frame)) =
                (0..2).find_map(|n| Some((n, self.nodes[n].transmit()?)))
            {
                let number = self.frames.len();
                self.frames.push((self.now, frame));
                if self.lost.contains(&number) {
                    continue;
                }
                self.nodes[1 - node].receive(self.now, &frame);
                if let Some(decoded) = self.ear.frame(&frame) {
                    let (message, values) = (decoded.message, decoded.values.to_vec());
                    let name = self.ear.layout().messages()[message].name.clone();
                    self.heard.push((self.now, name, values));
                }
            }
            let next = self.nodes.iter().map(|node| node.next_wakeup()).min().unwrap();
            if next > until {
                self.now = until;
                return;
            }
            self.now = next;
            self.nodes.iter_mut().for_each(|node| node.wake(next));
        }
    }
}

#[test]
fn what_is_for_everybody_goes_a_packet_each_50_ms() {
    let mut bus = Bus::new();
    bus.send(0, "Dm1", &[4.0, 9.0]);
    bus.run(at_ms(1_000));
    let times: Vec<Timestamp> = bus.frames.iter().map(|(at, _)| *at).collect();
    assert_eq!(times, [0, 50, 100, 150].map(at_ms));
    // As in J1939-21: 20 bytes in 3 packets, of group 65226 (0x00FECA).
    assert_eq!(bus.frames[0].1.data(), [32, 20, 0, 3, 255, 0xCA, 0xFE, 0]);
    assert_eq!(bus.frames[3].1.data()[..7], [3, 255, 255, 255, 255, 255, 9]);
    let heard = vec![(at_ms(150), "Dm1".to_owned(), vec![Some(4.0), Some(9.0)])];
    assert_eq!(bus.heard, heard);
}

#[test]
fn two_for_everybody_go_one_behind_the_other() {
    let mut bus = Bus::new();
    bus.send(0, "Dm1", &[1.0, 1.0]);
    bus.send(0, "Dm1", &[2.0, 2.0]);
    bus.run(at_ms(1_000));
    let times: Vec<Timestamp> = bus.heard.iter().map(|(at, ..)| *at).collect();
    assert_eq!(times, [150, 300].map(at_ms));
    assert_eq!(bus.ear.damaged(), 0);
}

/// The identifier of `Answer` is from address 40 to address 0.
#[test]
fn what_is_for_one_node_waits_for_its_leave() {
    let mut bus = Bus::new();
    bus.send(1, "Answer", &[77.0]);
    bus.run(at_ms(10));
    let said: Vec<u8> = bus.frames.iter().map(|(_, frame)| frame.data()[0]).collect();
    assert_eq!(said, [16, 17, 1, 2, 19], "request, leave, two packets, acknowledgement");
    let heard = vec![(Timestamp::ZERO, "Answer".to_owned(), vec![Some(77.0)])];
    assert_eq!(bus.heard, heard);
    assert_eq!(bus.nodes[1].given_up(), 0);
}

#[test]
fn a_packet_to_one_node_is_sent_again() {
    let mut bus = Bus::new();
    bus.send(1, "Answer", &[77.0]);
    bus.lost = vec![2];
    bus.run(at_ms(10));
    let said: Vec<u8> = bus.frames.iter().map(|(_, frame)| frame.data()[0]).collect();
    assert_eq!(said, [16, 17, 1, 2, 17, 1, 2, 19]);
    assert_eq!(bus.heard.len(), 1);
}

#[test]
fn who_gets_no_answer_gives_up_and_says_so() {
    let mut bus = Bus::new();
    bus.send(1, "Answer", &[77.0]);
    bus.send(1, "Answer", &[78.0]);
    bus.lost = vec![0];
    bus.run(at_ms(2_000));
    let (at, abort) = bus.frames[1];
    assert_eq!((at, abort.data()[0], abort.data()[1]), (at_ms(1_250), 255, j1939::TIMED_OUT));
    assert_eq!(bus.nodes[1].given_up(), 1);
    assert_eq!(bus.heard.len(), 1, "the next one is sent all the same");
    // The receiver also gives up if the packets do not come.
    let mut bus = Bus::new();
    bus.send(1, "Answer", &[77.0]);
    bus.lost = vec![2, 3];
    bus.run(at_ms(2_000));
    assert!(bus.heard.is_empty());
    assert_eq!(bus.nodes[1].given_up(), 1);
    assert_eq!(bus.frames.last().unwrap().1.data()[0], 255);
}

#[test]
fn a_packet_that_is_lost_to_everybody_loses_the_message() {
    let mut bus = Bus::new();
    bus.send(0, "Dm1", &[4.0, 9.0]);
    bus.lost = vec![2];
    bus.run(at_ms(1_000));
    assert!(bus.heard.is_empty());
    assert_eq!(bus.ear.damaged(), 1);
}

#[test]
fn the_longest_message_comes() {
    let mut bus = Bus::new();
    bus.send(0, "Text", &[513.0, 65_000.0]);
    bus.run(at_ms(20_000));
    assert_eq!(bus.frames.len(), 256);
    assert_eq!(bus.heard[0].2, [Some(513.0), Some(65_000.0)]);
}

#[test]
fn a_group_is_known_whoever_sends_it_with_whatever_priority() {
    let layout = layout("Engine");
    let speed = layout.find("Speed").unwrap();
    // The file leaves the source open, and gives the engine address 0.
    let sent = layout.messages()[speed].group().unwrap();
    assert_eq!((sent.group, sent.source, sent.priority), (61_444, 0, 3));
    let mut decoder = layout.decoder();
    let mut hears = |identifier: Identifier| {
        let frame = CanFrame::full(identifier.id(), [0, 0, 0, 0x40, 0x1F, 0, 0, 0]);
        decoder.frame(&frame).map(|decoded| decoded.values[0])
    };
    assert_eq!(hears(Identifier { priority: 6, ..sent }), Some(Some(1_000.0)));
    assert_eq!(hears(Identifier { source: 1, ..sent }), None, "of another engine");
    assert_eq!(hears(Identifier { group: 61_443, ..sent }), None);
}

proptest! {
    /// For any frames on the bus: no panic, and nothing is kept forever.
    #[test]
    fn no_frames_are_too_much(
        frames in prop::collection::vec((0..3u32, any::<[u8; 2]>(), any::<[u8; 8]>(), any::<bool>()), 0..300)
    ) {
        let layout = layout("Display");
        let mut transport = Transport::new(layout.addresses(Sender::Device).unwrap());
        let mut decoder = layout.decoder();
        let mut now = Timestamp::ZERO;
        for (kind, [to, from], mut data, is_near) in frames {
            let group = [0xEC00, 0xEB00, 0xFECA][kind as usize];
            let (destination, source) = if is_near { (40, 0) } else { (to, from) };
            if is_near && kind == 0 {
                data[0] = [16, 17, 19, 32, 255][usize::from(data[0]) % 5];
                data[3] = u16::from_le_bytes([data[1], data[2]]).div_ceil(7) as u8;
            }
            let id = Identifier { priority: 7, group, destination, source }.id();
            let frame = CanFrame::full(id, data);
            transport.receive(now, &frame);
            let _ = decoder.frame(&frame);
            while transport.transmit().is_some() {}
            now += Span::from_millis(100);
            transport.wake(now);
        }
        transport.wake(now + Span::from_secs(2));
        prop_assert_eq!(transport.next_wakeup(), Timestamp::MAX);
    }
}

/// A listener to an engine whose fault codes have `bytes` in the DBC.
fn listener(bytes: usize) -> Decoder {
    let dbc = format!(
        "BU_: Engine Display\nBO_ 2566834942 Dm1: {bytes} Engine\n SG_ Lamp : 0|8@1+ (1,0) [0|255] \"\" Display\n \
         SG_ Spn : 16|16@1+ (1,0) [0|65535] \"\" Display\n{}\n{}",
        if bytes > 8 { " SG_ Last : 72|8@1+ (1,0) [0|255] \"\" Display" } else { "" },
        &DBC[DBC.find("BA_DEF_").unwrap()..]
    );
    Layout::from_dbc("engine.dbc", &dbc, "Engine").unwrap().decoder()
}

/// What it hears of these frames of the engine, each so many ms after the one before, and what it counts as damage or as a
/// group of nobody.
fn heard(bytes: usize, frames: &[(i64, u32, &[u8])]) -> (Vec<Vec<Option<f64>>>, u64, u64) {
    let mut ear = listener(bytes);
    let (mut now, mut messages, mut foreign) = (Timestamp::ZERO, Vec::new(), 0);
    for (ms, id, data) in frames {
        now += Span::from_millis(*ms);
        let mut padded = [0xFF; 8];
        padded[..data.len()].copy_from_slice(data);
        let frame = CanFrame::full(wire::can::ExtendedId::new(*id).unwrap(), padded);
        assert!(ear.takes(frame.id()) || *id == 0x18FE_EE00);
        messages.extend(ear.at(now).frame(&frame).map(|decoded| decoded.values.to_vec()));
        foreign += u64::from(ear.foreign().is_some());
    }
    (messages, ear.damaged(), foreign)
}

const SINGLE: u32 = 0x18FE_CA00;
const BEGIN: u32 = 0x1CEC_FF00;
const PACKET: u32 = 0x1CEB_FF00;
/// The announcement of ten bytes of DM1: two fault codes.
const TEN: &[u8] = &[32, 10, 0, 2, 255, 0xCA, 0xFE, 0];

/// Found by a user: a red lamp that came in packets, because there were two faults, was never seen.
#[test]
fn a_group_of_eight_bytes_may_come_in_packets_and_a_longer_one_in_a_frame() {
    let first: &[u8] = &[1, 16, 0xFF, 0x34, 0x12];
    let second: &[u8] = &[2, 7, 8, 9];
    let in_parts = [(0, BEGIN, TEN), (50, PACKET, first), (50, PACKET, second)];
    let alone = [(0, SINGLE, &[16, 0xFF, 0x34, 0x12][..])];
    assert_eq!(heard(8, &in_parts), (vec![vec![Some(16.0), Some(4660.0)]], 0, 0));
    assert_eq!(heard(10, &in_parts), (vec![vec![Some(16.0), Some(4660.0), Some(9.0)]], 0, 0));
    assert_eq!(heard(14, &in_parts), (vec![vec![Some(16.0), Some(4660.0), Some(9.0)]], 0, 0));
    assert_eq!(heard(8, &alone), (vec![vec![Some(16.0), Some(4660.0)]], 0, 0));
    assert_eq!(heard(14, &alone), (vec![vec![Some(16.0), Some(4660.0), None]], 0, 0));
}

/// Found by a user: the first frame of an NMEA 2000 fast packet counted as all of its group, and nothing said so.
#[test]
fn a_longer_group_that_comes_in_a_frame_is_named() {
    let id = wire::can::ExtendedId::new(SINGLE).unwrap();
    let frame = CanFrame::full(id, [0, 43, 1, 2, 3, 4, 5, 6]);
    for (bytes, expected) in [(8, vec![]), (43, vec![("Dm1", 2)])] {
        let mut ear = listener(bytes);
        let heard = [(); 2].map(|()| ear.frame(&frame).is_some());
        let alone: Vec<_> = ear.alone().map(|(of, count)| (&*of.name, count)).collect();
        assert_eq!((heard, alone, ear.damaged()), ([true; 2], expected, 0));
    }
}

/// Found by a user: none of these was counted.
#[test]
fn messages_that_do_not_become_whole_are_counted_once() {
    let (one, two): (&[u8], &[u8]) = (&[1, 16], &[2, 7]);
    let begin = (1_000, BEGIN, TEN);
    let bad: &[u8] = &[32, 14, 0, 3, 255, 0xCA, 0xFE, 0];
    let other: &[u8] = &[32, 10, 0, 2, 255, 0xDA, 0xFE, 0];
    for (what, frames, whole, damaged, foreign) in [
        ("whole", vec![begin, (50, PACKET, one), (50, PACKET, two)], 1, 0, 0),
        ("again and again", [begin, (50, PACKET, one), (50, PACKET, two)].repeat(3), 3, 0, 0),
        (
            "the last is missing",
            vec![begin, (50, PACKET, one), begin, (50, PACKET, one), (50, PACKET, two)],
            1,
            1,
            0,
        ),
        ("both are missing", vec![begin, begin, (50, PACKET, one), (50, PACKET, two)], 1, 1, 0),
        ("nothing follows", vec![begin, (50, PACKET, one), (1_000, SINGLE, one)], 1, 1, 0),
        ("the first is missing", vec![begin, (50, PACKET, two)], 0, 1, 0),
        ("no announcement", vec![(0, PACKET, one), (50, PACKET, two)], 0, 2, 0),
        ("3 packets for 14 bytes", vec![(0, BEGIN, bad)], 0, 1, 0),
        ("too late", vec![begin, (50, PACKET, one), (751, PACKET, two)], 0, 1, 0),
        ("just in time", vec![begin, (50, PACKET, one), (750, PACKET, two)], 1, 0, 0),
        ("another group", vec![(0, BEGIN, other), (50, PACKET, one), (50, PACKET, two)], 0, 0, 1),
        ("doubled", vec![begin, (50, PACKET, one), (0, PACKET, one), (50, PACKET, two)], 1, 0, 0),
    ] {
        let (messages, counted, of_nobody) = heard(8, &frames);
        assert_eq!((messages.len(), counted, of_nobody), (whole, damaged, foreign), "{what}");
    }
}

#[test]
fn bits_without_a_signal_are_ones() {
    let layout = layout("Engine");
    let speed = layout.find("Speed").unwrap();
    let encoded = layout.encode(speed, &[1_000.0]).unwrap();
    let wire::device::Transmit::Frame(frame) = encoded else { panic!("a frame") };
    assert_eq!(frame.data(), [0xFF, 0xFF, 0xFF, 0x40, 0x1F, 0xFF, 0xFF, 0xFF]);
}
