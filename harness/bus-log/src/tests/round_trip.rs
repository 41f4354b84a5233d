//! Written entries can be read, as far as the format can hold them; and no bytes make a reader panic.

use super::samples::{any_entry, any_frame, read, written};
use crate::convert::convert;
use crate::{
    Channel, Direction, Entry, ErrorFrame, Format, LogError, LogReader, LogWriter, Payload,
};
use proptest::prelude::*;
use std::io::Cursor;
use std::path::Path;
use wire::can::{CanFrame, Id, StandardId};
use wire::packet::{BYTES_MAX, Packet};
use wire::time::Timestamp;

/// In whole microseconds.
fn in_micros(entry: Entry) -> Entry {
    Entry { at: Timestamp::from_nanos(entry.at.as_nanos() / 1_000 * 1_000), ..entry }
}

fn is_serial(entry: &Entry) -> bool {
    matches!(entry.payload, Payload::Serial(_))
}

/// Frames on numbered channels, each this number of microseconds after the previous one.
fn numbered(mut micros: i64, frames: Vec<(Payload, i64, u32, bool)>) -> Vec<Entry> {
    let entry = |(payload, later, channel, sent)| {
        let at = Timestamp::from_nanos(micros * 1_000);
        let direction = Some(if sent { Direction::Tx } else { Direction::Rx });
        micros += later;
        Entry { at, channel: Channel::numbered(channel), direction, payload }
    };
    frames.into_iter().map(entry).collect()
}

/// An error frame without its details, as read from formats that do not keep them.
fn bare_error(entry: Entry) -> Entry {
    let payload = Payload::Error(ErrorFrame::BUS_ERROR);
    match entry.payload {
        Payload::Error(_) => Entry { payload, direction: None, ..entry },
        _ => entry,
    }
}

proptest! {
    #[test]
    fn a_candump_log_comes_back(entries in prop::collection::vec(any_entry(), 0..20)) {
        let (again, error) = read(Format::Candump, &written(Format::Candump, &entries));
        prop_assert!(error.is_none(), "{:?}", error);
        let expected: Vec<_> =
            entries.into_iter().filter(|entry| !is_serial(entry)).map(in_micros).collect();
        prop_assert_eq!(again, expected);
    }

    #[test]
    fn a_pcapng_file_comes_back_whole(entries in prop::collection::vec(any_entry(), 0..20)) {
        let (again, error) = read(Format::Pcapng, &written(Format::Pcapng, &entries));
        prop_assert!(error.is_none(), "{:?}", error);
        prop_assert_eq!(again, entries);
    }

    #[test]
    fn an_asc_file_comes_back(
        began_ms in 0i64..4_000_000_000_000,
        frames in prop::collection::vec(
            (any_frame(), 0i64..10_000_000_000, 0u32..4, any::<bool>()), 0..20),
    ) {
        let entries = numbered(began_ms * 1_000, frames);
        let (again, error) = read(Format::Asc, &written(Format::Asc, &entries));
        prop_assert!(error.is_none(), "{:?}", error);
        let expected: Vec<_> = entries.into_iter().map(bare_error).collect();
        prop_assert_eq!(again, expected);
    }

    #[test]
    fn a_trc_file_comes_back(
        began in 0i64..4_000_000_000_000_000,
        frames in prop::collection::vec(
            (any_frame(), 0i64..10_000_000_000, 0u32..4, any::<bool>()), 0..20),
    ) {
        let entries = numbered(began, frames);
        let (again, error) = read(Format::Trc, &written(Format::Trc, &entries));
        prop_assert!(error.is_none(), "{:?}", error);
        let expected: Vec<_> = entries.into_iter().map(bare_error).collect();
        prop_assert_eq!(again, expected);
    }

    #[test]
    fn blf_and_mdf4_files_come_back_to_the_nanosecond(
        began_ms in 0i64..4_000_000_000_000,
        frames in prop::collection::vec(
            (any_frame(), 0i64..10_000_000_000, 0u32..4, any::<bool>()), 0..20),
        part in 0i64..1_000,
    ) {
        let mut entries = numbered(began_ms * 1_000, frames);
        for entry in &mut entries {
            entry.at = Timestamp::from_nanos(entry.at.as_nanos() + part);
        }
        let (again, error) = read(Format::Blf, &written(Format::Blf, &entries));
        prop_assert!(error.is_none(), "{:?}", error);
        let mut expected: Vec<_> = entries.iter().copied().map(bare_error).collect();
        prop_assert_eq!(&again, &expected);
        let (again, error) = read(Format::Mdf4, &written(Format::Mdf4, &entries));
        prop_assert!(error.is_none(), "{:?}", error);
        // One group per kind: at the same time frames come before remote requests, and those before errors.
        expected.sort_by_key(|entry| (entry.at, match entry.payload {
            Payload::Frame(frame) => u8::from(frame.is_remote()),
            _ => 2,
        }));
        prop_assert_eq!(again, expected);
    }

    #[test]
    fn no_bytes_make_a_reader_panic(
        bytes in prop::collection::vec(any::<u8>(), 0..300),
        lines in prop::collection::vec(
            prop::sample::select(vec![
                "(1.5) can0 ", "123#", "R", "##3", "12345678#", "00", "F", " T", "_9", "\n",
                "base dec", "base hex  timestamps relative", "date Sat Sep 30 15:06:13 2017",
                "0.5 1 ", "CANFD 1 Rx ", "7FFx ", " Rx ", "d 8 ", "r 9 ", "0 1 f 64 ", "ErrorFrame",
                ";$FILEVERSION=2.1", ";$STARTTIME=44548.6", ";$COLUMNS=N,O,T,B,I,d,R,L,D", "1 5.5 FD 1 ",
            ]), 0..60),
        cut in 0usize..400,
        flipped in prop::option::of((0usize..400, any::<u8>())),
        entries in prop::collection::vec(any_entry(), 1..4),
    ) {
        let mut packets = written(Format::Pcapng, &entries);
        packets.truncate(packets.len().saturating_sub(cut).max(1));
        if let Some((index, byte)) = flipped {
            let index = index % packets.len();
            packets[index] = byte;
        }
        for format in Format::ALL {
            for bytes in [&bytes[..], lines.concat().as_bytes(), &packets] {
                let (entries, _) = read(format, bytes);
                prop_assert!(entries.len() <= bytes.len());
            }
        }
    }
}

#[test]
fn a_channel_too_many_is_left_out() {
    use crate::Kept;
    let path = Path::new("bus.log");
    let limits = [
        (Format::Asc, 32),
        (Format::Pcapng, 256),
        (Format::Trc, 16),
        (Format::Blf, 32),
        (Format::Mdf4, 32),
    ];
    for (format, most) in limits {
        let mut writer = LogWriter::new(path, Cursor::new(Vec::new()), format).unwrap();
        for number in 0..=most {
            let entry = Entry {
                at: Timestamp::ZERO,
                channel: Channel::numbered(number),
                direction: None,
                payload: Payload::Error(ErrorFrame::BUS_ERROR),
            };
            let kept = if number < most { Kept::Written } else { Kept::LeftOut };
            assert_eq!(writer.write(&entry).unwrap(), kept, "{format:?} {number}");
        }
    }
}

/// Contents of the first container of a BLF file.
fn unpacked(blf: &[u8]) -> Vec<u8> {
    // The heads of the file and of the container.
    let mut objects = Vec::new();
    let mut decoder = flate2::read::ZlibDecoder::new(&blf[144 + 32..]);
    std::io::Read::read_to_end(&mut decoder, &mut objects).unwrap();
    objects
}

#[test]
fn a_file_without_names_says_which_channel_is_which_number() {
    let entries: Vec<_> = ["can1", "body", "can1"]
        .into_iter()
        .map(|name| Entry {
            at: Timestamp::ZERO,
            channel: Channel::new(name).unwrap(),
            direction: Some(Direction::Rx),
            payload: Payload::Frame(CanFrame::new(Id::Standard(StandardId::ZERO), &[1]).unwrap()),
        })
        .collect();
    for (format, names) in [
        (Format::Asc, ["// channel 2 is can1\n", "// channel 1 is body\n"]),
        (Format::Trc, [";   Bus 2 is can1\r\n", ";   Bus 1 is body\r\n"]),
        (Format::Blf, ["channel 2 is can1", "channel 1 is body"]),
        (Format::Mdf4, [r#"<e name="channel 2">can1</e>"#, r#"<e name="channel 1">body</e>"#]),
    ] {
        let bytes = written(format, &entries);
        let text = if format == Format::Blf { unpacked(&bytes) } else { bytes.clone() };
        let text = String::from_utf8_lossy(&text);
        for name in names {
            assert_eq!(text.matches(name).count(), 1, "{format:?}: {name}");
        }
        let mut reader = LogReader::new(Path::new("bus.log"), Cursor::new(&bytes), format).unwrap();
        let channels: Vec<_> =
            reader.by_ref().map(|entry| entry.unwrap().channel.to_string()).collect();
        assert_eq!(channels, ["can1", "can0", "can1"], "{format:?}");
        assert_eq!((reader.passed_over(), reader.notes()), (0, Vec::new()), "{format:?}");
    }
}

#[test]
fn a_conversion_tells_the_numbers_of_channels_without_names() {
    let entry = |name| Entry {
        at: Timestamp::ZERO,
        channel: Channel::new(name).unwrap(),
        direction: None,
        payload: Payload::Error(ErrorFrame::BUS_ERROR),
    };
    let told = |format| {
        let entries = [Ok::<_, LogError>(entry("can1")), Ok(entry("body"))];
        let writer = LogWriter::new(Path::new("bus.log"), Cursor::new(Vec::new()), format);
        convert(entries, writer.unwrap()).unwrap().to_string()
    };
    assert_eq!(told(Format::Asc), "2 entries; channel 1 is body, 2 is can1");
    assert_eq!(told(Format::Candump), "2 entries");
}

#[test]
fn channels_of_an_asc_file_have_numbers() {
    let entries: Vec<_> = ["vcan0", "can1", "can0", "vcan0", "can7"]
        .into_iter()
        .map(|name| Entry {
            at: Timestamp::ZERO,
            channel: Channel::new(name).unwrap(),
            direction: None,
            payload: Payload::Error(ErrorFrame::BUS_ERROR),
        })
        .collect();
    let text = String::from_utf8(written(Format::Asc, &entries)).unwrap();
    let numbers: Vec<_> = text
        .lines()
        .filter(|line| line.ends_with("ErrorFrame"))
        .filter_map(|line| line.split_whitespace().nth(1))
        .collect();
    // can1 is 2; can0 finds 1 taken by vcan0, and gets the lowest free number.
    assert_eq!(numbers, ["1", "2", "3", "1", "8"]);
}

/// Found by a user: a file with a packet longer than those of a run could not be read at all.
#[test]
fn a_long_packet_of_a_serial_line_is_several_entries() {
    let packet = Payload::Serial(Packet::from_slice(b"$").unwrap());
    let mut bytes = written(Format::Pcapng, &numbered(0, vec![(packet, 0, 1, false)]));
    let sentence = [b'x'; 300];
    let length = (32 + sentence.len()) as u32;
    // An enhanced packet block: type, length, interface, time, captured and original length, data, length.
    let head = [6, length, 0, 0, 7_000, sentence.len() as u32, sentence.len() as u32];
    bytes.extend(head.iter().flat_map(|word| word.to_le_bytes()));
    bytes.extend(sentence);
    bytes.extend(length.to_le_bytes());
    let (entries, error) = read(Format::Pcapng, &bytes);
    assert!(error.is_none(), "{error:?}");
    let lengths = entries.iter().map(|entry| match &entry.payload {
        Payload::Serial(packet) => packet.len(),
        other => panic!("{other:?}"),
    });
    assert_eq!(lengths.collect::<Vec<_>>(), [1, BYTES_MAX, BYTES_MAX, 300 - 2 * BYTES_MAX]);
    assert!(entries[1..].iter().all(|entry| entry.at == Timestamp::from_nanos(7_000)));
}
