//! Complete layouts: round trips, damage, and comparison with the hand-written codec of the same messages.

use super::Sender;
use super::message::{Carrier, Found, Message};
use super::number::{Coding, Scale};
use super::selection::Carried;
use super::signal::{Signal, Storage};
use super::{Decoded, EncodeError, Layout, Medium, SignalName};
use crate::Description;
use crate::bits::BitField;
use crate::file::ByteOrder;
use crate::protection::Verdict;
use proptest::prelude::*;
use wire::can::{CanFrame, Id, StandardId};
use wire::device::Transmit;
use wire::packet::BYTES_MAX;

/// Packets in both directions and a line.
const SERIAL: &str = r#"
name = "meter"
[serial]
baud = 115200
[[message]]
name = "Status"
sent_by = "device"
start = [0xAA, 0x55]
checksum = "crc16-modbus"
fields = [
  { name = "Temperature", type = "i16", scale = 0.01, unit = "degC" },
  { name = "Pressure", type = "u24", order = "big", scale = 0.5, offset = -100 },
  { name = "Ratio", type = "f32" },
]
[[message]]
name = "Command"
sent_by = "host"
start = [0xAA, 0x56]
checksum = "sum8"
checksum_over = "all"
fields = [{ name = "Setpoint", type = "u8" }]
[[message]]
name = "Reading"
sent_by = "device"
text = "T={Temperature:.2} H={HeaterOn:.0}\r\n"
"#;

pub(crate) fn described(text: &str) -> Description {
    let read = &mut |name: &str| Err(format!("no file {name} in this test"));
    Description::parse("test.toml", text, read).unwrap_or_else(|error| panic!("{error}"))
}

fn serial() -> Layout {
    described(SERIAL).layout().clone()
}

fn bytes(wired: Transmit) -> Vec<u8> {
    match wired {
        Transmit::Bytes(packet) => packet.as_slice().to_vec(),
        Transmit::Frame(frame) => frame.data().to_vec(),
    }
}

/// A decoded message: its index, and its values.
type Read = (usize, Vec<Option<f64>>);

fn read(decoded: Decoded<'_>) -> Read {
    (decoded.message, decoded.values.to_vec())
}

fn heard(layout: &Layout, data: &[u8]) -> (Vec<Read>, u64) {
    let (mut decoder, mut found) = (layout.decoder(), Vec::new());
    decoder.bytes(data, &mut |decoded| found.push(read(decoded)));
    (found, decoder.damaged())
}

fn status(layout: &Layout) -> (Vec<u8>, Read) {
    let values = [-12.34, 250.5, 0.25];
    let packet = bytes(layout.encode(0, &values).unwrap());
    (packet, (0, values.map(Some).to_vec()))
}

#[test]
fn a_packet_has_its_bytes_where_the_file_says() {
    let (packet, decoded) = status(&serial());
    assert_eq!(packet[..2], [0xaa, 0x55]);
    assert_eq!(packet[2..4], (-1234i16).to_le_bytes());
    assert_eq!(packet[4..7], 701u32.to_be_bytes()[1..]);
    assert_eq!(packet[7..11], 0.25f32.to_le_bytes());
    let crc = crc::Crc::<u16>::new(&crc::CRC_16_MODBUS).checksum(&packet[2..11]);
    assert_eq!(packet[11..], crc.to_le_bytes());
    let (found, damaged) = heard(&serial(), &packet);
    assert_eq!((found.len(), damaged), (1, 0));
    for (found, expected) in found[0].1.iter().zip(&decoded.1) {
        assert!((found.unwrap() - expected.unwrap()).abs() < 1e-9);
    }
    let command = bytes(serial().encode(1, &[7.0]).unwrap());
    assert_eq!(command, [0xaa, 0x56, 7, 7]);
}

/// The time on the line of the question and the answer of a meter: 12 bytes of eleven bits.
#[test]
fn a_second_stop_bit_takes_its_time() {
    let of = |settings: &str| {
        let text = format!("name = \"m\"\n[serial]\nbaud = 1200\n{settings}\n");
        let message = "[[message]]\nname = \"R\"\nsent_by = \"device\"\ntext = \"{x}\\n\"\n";
        match described(&(text + message)).layout().medium() {
            Medium::Serial(settings) => settings.time_for(12),
            Medium::Can => panic!("on a serial line"),
        }
    };
    assert_eq!(of("").as_secs_f64(), 0.1);
    assert_eq!(of("stop_bits = 2").as_secs_f64(), 0.11);
}

#[test]
fn a_damaged_packet_is_refused_and_the_next_one_found() {
    let layout = serial();
    let (packet, expected) = status(&layout);
    for damaged in 0..packet.len() {
        for bit in 0..8 {
            let mut data = packet.clone();
            data[damaged] ^= 1 << bit;
            data.extend_from_slice(&packet);
            let (mut decoder, mut found) = (layout.decoder(), Vec::new());
            decoder.bytes(&data, &mut |decoded| found.push(read(decoded)));
            assert_eq!(found.len(), 1, "byte {damaged} bit {bit}");
            assert_eq!(found[0].0, expected.0);
            // Without its first two bytes it is no message at all.
            let spoilt: Vec<_> = decoder.spoilt().map(|(of, count)| (&*of.name, count)).collect();
            match damaged < 2 {
                true => assert_eq!((decoder.damaged(), spoilt), (packet.len() as u64, vec![])),
                false => assert_eq!((decoder.damaged(), spoilt), (0, vec![("Status", 1)])),
            }
        }
    }
}

/// To a receiver the message is lost, and its sender counted on: it is not to blame.
#[test]
fn the_counter_of_a_packet_with_a_wrong_checksum_goes_on() {
    let text = r#"
        name = "sensor"
        [serial]
        baud = 115200
        [[message]]
        name = "Status"
        sent_by = "device"
        start = [0xAA, 0x55]
        checksum = "crc16-modbus"
        counter = { signal = "Alive" }
        fields = [{ name = "Alive", type = "u8" }, { name = "Level", type = "u16" }]
    "#;
    let layout = described(text).layout().clone();
    let packet = |number: f64, spoilt: bool| {
        let mut data = bytes(layout.encode(0, &[number, 700.0]).unwrap());
        data[4] ^= u8::from(spoilt);
        data
    };
    let mut verdicts = Vec::new();
    let mut decoder = layout.decoder();
    for (number, spoilt) in [(0, false), (1, true), (2, false), (4, false)] {
        let data = packet(f64::from(number), spoilt);
        decoder.bytes(&data, &mut |found| verdicts.push(found.verdict));
    }
    let expected = [Verdict::Ok, Verdict::LostToDamage(1), Verdict::Lost(1)].map(Some);
    assert_eq!(verdicts, expected);
    assert_eq!((decoder.spoilt().count(), decoder.damaged()), (1, 0));
    // Behind garbage, what looks like its beginning may be anything.
    decoder.bytes(&[0], &mut |_| ());
    decoder.bytes(&packet(5.0, true), &mut |_| ());
    decoder.bytes(&packet(6.0, false), &mut |found| verdicts.push(found.verdict));
    assert_eq!((verdicts.last(), decoder.damaged()), (Some(&Some(Verdict::Lost(1))), 8));
}

#[test]
fn each_end_hears_the_other_alone() {
    let layout = serial();
    let command = bytes(layout.encode(1, &[7.0]).unwrap());
    let count = |sender| {
        let (mut decoder, mut found) = (layout.decoder_for(sender), 0);
        decoder.bytes(&command, &mut |_| found += 1);
        found
    };
    assert_eq!((count(Sender::Host), count(Sender::Device)), (1, 0));
}

/// Found by a user: a receiver of NMEA 0183 takes up at `$`, whatever is before it.
#[test]
fn a_line_with_a_character_that_begins_it_is_found_behind_anything() {
    let text = "name = \"wind\"\n[serial]\nbaud = 4800\n[[message]]\nname = \"W\"\nsent_by = \"device\"\n\
        text = \"START{x:.1},R*{checksum}\\r\\n\"\nchecksum = \"xor8\"\n";
    for (start, is_found) in [("$W,", true), ("W,", false)] {
        let layout = described(&text.replace("START", start)).layout().clone();
        let line = bytes(layout.encode(0, &[45.0]).unwrap());
        let short = line.len() - 2;
        for before in [&b"0"[..], b"$", &line[..5], &line[..short]] {
            let (found, damaged) = heard(&layout, &[before, &line].concat());
            let expected = if is_found { before.len() } else { before.len() + short };
            assert_eq!((found.len() == 1, damaged >= before.len() as u64), (is_found, true));
            assert!(damaged >= expected as u64, "{start} {damaged}");
            assert!(!is_found || damaged == expected as u64, "{start} {damaged}");
        }
    }
}

#[test]
fn a_line_is_not_read_from_its_middle() {
    let layout = described(
        "name = \"m\"\n[serial]\nbaud = 9600\n[[message]]\nname = \"R\"\nsent_by = \"device\"\ntext = \"{x}\\n\"\n",
    );
    let (found, damaged) = heard(layout.layout(), b"noise 15\n2.5\n");
    assert_eq!(found, [(0, vec![Some(2.5)])]);
    assert_eq!(damaged, 9);
    // A number without an end is discarded, not kept.
    let (found, damaged) = heard(layout.layout(), &[b'1'; 10 * BYTES_MAX]);
    assert_eq!(found, []);
    assert!(damaged > 9 * BYTES_MAX as u64);
}

#[test]
fn what_does_not_fit_is_said_by_name() {
    let layout = serial();
    let error = layout.encode(0, &[400.0, 0.0, 0.0]).unwrap_err();
    insta::assert_snapshot!(error, @"`Status.Temperature` cannot be 400 degC: its range is -327.68 to 327.67 degC");
    let error = layout.encode(0, &[1.0]).unwrap_err();
    insta::assert_snapshot!(error, @"failed to encode `Status`: it has 3 signals, and 1 values came");
    assert_eq!(layout.encode(9, &[]), Err(EncodeError::NoMessage(9)));
    for value in [f64::NAN, f64::INFINITY] {
        assert!(layout.encode(0, &[value, 0.0, 0.0]).is_err());
        assert!(layout.encode(2, &[value, 0.0]).is_err());
    }
}

#[test]
fn signals_are_found_by_name() {
    let layout = serial();
    assert_eq!(layout.signal("Pressure"), Some((0, 1)));
    assert_eq!(layout.signal("Reading.Temperature"), Some((2, 0)));
    assert_eq!(layout.signal("Temperature"), None);
    let error = |name| match layout.resolve(name).unwrap_err() {
        SignalName::Unknown { help, .. } | SignalName::Ambiguous { help, .. } => help,
    };
    assert_eq!(error("Temperature"), "say which: `Status.Temperature` or `Reading.Temperature`");
    assert_eq!(error("Presure"), "did you mean `Pressure`?");
    assert_eq!(error("Status.Presure"), "did you mean `Status.Pressure`?");
}

fn any_signal() -> impl Strategy<Value = Signal> {
    let order = prop_oneof![Just(ByteOrder::Little), Just(ByteOrder::Big)];
    // Up to 52 bits a double holds every count.
    let coding = prop_oneof![Just(Coding::Unsigned), Just(Coding::Signed)];
    let factor = prop_oneof![Just(1.0), Just(0.01), Just(-0.5), Just(1e-6)];
    (order, 0u64..64, 1u64..=40, coding, factor, -100.0..100.0).prop_filter_map(
        "inside",
        |(order, start, length, coding, factor, offset)| {
            let field = BitField::new(order, start, length, 8)?;
            let scale = Scale::new(factor, offset)?;
            let (least, greatest) = coding.limits(field.length());
            let (minimum, maximum) = scale.range(least, greatest);
            Some(Signal {
                name: format!("s{start}"),
                unit: String::new(),
                minimum,
                maximum,
                doc: String::new(),
                carried: Carried::Always,
                multiplexes: false,
                named_values: Vec::new(),
                start: 0.0,
                scale,
                storage: Storage::Bits { field, coding },
            })
        },
    )
}

fn any_layout() -> impl Strategy<Value = Layout> {
    prop::collection::vec(any_signal(), 1..12).prop_map(|signals| {
        let mut kept: Vec<Signal> = Vec::new();
        for signal in signals {
            if kept.iter().all(|other| !other.overlaps(&signal)) {
                kept.push(signal);
            }
        }
        let id = Id::Standard(StandardId::ZERO);
        let message = Message {
            name: "M".to_owned(),
            sender: Sender::Device,
            period: None,
            signals: kept,
            doc: String::new(),
            send: super::SendRule::default(),
            carrier: Carrier::Frame { id, length: 8, fd: None },
            group: None,
            protected: None,
            told_by: None,
        };
        Layout::new(Medium::Can, vec![message])
    })
}

proptest! {
    #[test]
    fn what_is_encoded_is_decoded_up_to_the_resolution(
        layout in any_layout(), parts in prop::collection::vec(0.0f64..=1.0, 12)
    ) {
        let signals = &layout.messages()[0].signals;
        let values: Vec<f64> = signals
            .iter()
            .zip(&parts)
            .map(|(signal, part)| signal.minimum + part * (signal.maximum - signal.minimum))
            .collect();
        let Transmit::Frame(frame) = layout.encode(0, &values).unwrap() else { panic!("on CAN") };
        let mut decoder = layout.decoder();
        let decoded = decoder.frame(&frame).unwrap();
        for ((signal, value), found) in signals.iter().zip(&values).zip(decoded.values) {
            let error = (found.unwrap() - value).abs();
            prop_assert!(error <= 0.5 * signal.resolution() * (1.0 + 1e-3), "{error} {signal:?}");
        }
        // Encoding the decoded values gives the same bytes.
        let again: Vec<f64> = decoded.values.iter().copied().flatten().collect();
        prop_assert_eq!(layout.encode(0, &again).unwrap(), Transmit::Frame(frame));
    }

    #[test]
    fn no_frame_makes_a_decoder_panic(
        layout in any_layout(), data in prop::collection::vec(any::<u8>(), 0..=8)
    ) {
        let frame = CanFrame::new(StandardId::ZERO, &data).unwrap();
        let mut decoder = layout.decoder();
        let whole = decoder.frame(&frame).is_some();
        let short = u64::from(data.len() < 8);
        prop_assert_eq!((whole, decoder.damaged()), (data.len() == 8, short));
        prop_assert_eq!(decoder.short().map(|(_, count)| count).sum::<u64>(), short);
    }

    /// After any garbage, a good packet is found once at most one more packet's bytes have arrived; unless the garbage
    /// together with the packet's first bytes forms a good packet of another message, which an 8-bit checksum permits.
    #[test]
    fn behind_garbage_the_next_packet_is_found(
        garbage in prop::collection::vec(prop_oneof![
            any::<u8>(), prop::sample::select(b"\xaa\x55\x56T=1 H=.e\r\n".to_vec())
        ], 0..100),
        pieces in 1usize..20
    ) {
        let layout = serial();
        let (packet, expected) = status(&layout);
        let mut data = garbage.clone();
        data.extend_from_slice(&packet);
        data.extend_from_slice(&[0; BYTES_MAX]);
        let (mut decoder, mut found) = (layout.decoder(), Vec::new());
        for piece in data.chunks(pieces) {
            decoder.bytes(piece, &mut |decoded| found.push(read(decoded)));
        }
        let is_message = |at: usize| {
            layout.messages().iter().any(|message| {
                let found = message.find(&data[at..], &mut Vec::new());
                matches!(found, Found::Whole(length) if at + length > garbage.len())
            })
        };
        if !(0..garbage.len()).any(is_message) {
            prop_assert_eq!(found.last().map(|last| last.0), Some(expected.0));
        }
        let (whole, damaged) = heard(&layout, &data);
        prop_assert_eq!((whole, damaged), (found, decoder.damaged()));
    }
}
