//! Objects that other programs write into BLF files, and damaged files.

use super::samples::{read, written};
use crate::{Channel, Direction, Entry, ErrorFrame, Format, Payload};
use wire::can::{CanFrame, ExtendedId, FdFlags, StandardId};
use wire::time::Timestamp;

/// Saturday 2017-09-30 15:06:13.191.
const BEGAN: [u8; 16] = [0xe1, 7, 9, 0, 6, 0, 30, 0, 15, 0, 6, 0, 13, 0, 191, 0];
const BEGAN_NS: i64 = 1_506_783_973_191_000_000;

/// An object with a time, with a head of the length for its version.
fn object(kind: u32, head: usize, flags: u32, time: u64, body: &[u8]) -> Vec<u8> {
    let mut bytes = b"LOBJ".to_vec();
    bytes.extend((head as u16).to_le_bytes());
    bytes.extend(if head == 32 { [1, 0] } else { [2, 0] });
    bytes.extend(((head + body.len()) as u32).to_le_bytes());
    bytes.extend(kind.to_le_bytes());
    bytes.extend(flags.to_le_bytes());
    bytes.extend([0; 4]);
    bytes.extend(time.to_le_bytes());
    bytes.resize(head, 0);
    bytes.extend(body);
    bytes
}

/// A file with uncompressed containers of this length.
fn file(objects: &[Vec<u8>], container: usize) -> Vec<u8> {
    let mut bytes = b"LOGG".to_vec();
    bytes.extend(144u32.to_le_bytes());
    bytes.resize(40, 0);
    bytes.extend(BEGAN);
    bytes.resize(144, 0);
    for part in objects.concat().chunks(container) {
        bytes.extend(b"LOBJ");
        bytes.extend([16, 0, 1, 0]);
        bytes.extend((32 + part.len() as u32).to_le_bytes());
        bytes.extend(10u32.to_le_bytes());
        bytes.extend([0; 8]);
        bytes.extend((part.len() as u32).to_le_bytes());
        bytes.extend([0; 4]);
        bytes.extend(part);
        bytes.extend(vec![0; part.len() % 4]);
    }
    bytes
}

/// `CAN_FD_MESSAGE_64` with these data bytes, optionally followed by further data.
fn fd_64(code: u8, length: u8, flags: u32, way: u8, behind: u8, data: &[u8]) -> Vec<u8> {
    let mut body = vec![2, code, length, 0, 0x34, 0x12, 0, 0x80, 0, 0, 0, 0];
    body.extend(flags.to_le_bytes());
    body.resize(34, 0);
    body.extend([way, behind, 0, 0, 0, 0]);
    body.extend(data);
    body
}

fn entry(at: i64, channel: u32, direction: Option<Direction>, payload: Payload) -> Entry {
    let at = Timestamp::from_nanos(BEGAN_NS + at);
    Entry { at, channel: Channel::numbered(channel), direction, payload }
}

fn objects() -> Vec<Vec<u8>> {
    let data = [1, 2, 3, 4, 5, 6, 7, 8];
    let mut message = vec![1, 0, 1, 3, 0x23, 1, 0, 0];
    message.extend(data);
    let mut remote = vec![1, 0, 0x80, 2, 0x23, 1, 0, 0];
    remote.extend([0; 8]);
    let mut longer = message.clone();
    longer.extend([9; 8]);
    let twelve: Vec<u8> = (0..12).collect();
    let mut with_more = twelve.clone();
    with_more.extend([0xee; 12]);
    vec![
        object(1, 32, 1, 150, &message),
        object(1, 32, 2, 1_500_001, &remote),
        object(86, 40, 2, 1_500_002, &longer),
        object(96, 32, 2, 1_500_002, b"a marker of the program"),
        // Two bytes after an object of 55 bytes.
        vec![0; 2],
        object(101, 40, 2, 1_500_003, &fd_64(9, 12, 0x7000, 1, 0, &twelve)),
        object(101, 32, 2, 1_500_004, &fd_64(9, 12, 0x1000, 0, 32 + 52, &with_more)),
        // Fewer data bytes than the length says.
        object(101, 32, 2, 1_500_005, &fd_64(9, 12, 0x1000, 0, 0, &twelve[..8])),
        object(101, 32, 2, 1_500_006, &fd_64(3, 3, 0, 0, 0, &twelve[..3])),
        object(101, 32, 2, 1_500_007, &fd_64(8, 0, 0x10, 0, 0, &[])),
        object(101, 32, 2, 1_500_008, &fd_64(8, 0, 0x10, 2, 0, &[])),
        object(2, 32, 2, 1_500_009, &[1, 0, 0, 0]),
        object(73, 32, 2, 1_500_010, &[[2, 0], [0; 2]].concat()),
        object(104, 32, 2, 1_500_011, &[2, 0, 0, 0]),
    ]
}

fn entries() -> Vec<Entry> {
    let standard = StandardId::new(0x123).unwrap();
    let extended = ExtendedId::new(0x1234).unwrap();
    let (rx, tx) = (Some(Direction::Rx), Some(Direction::Tx));
    let classic = |data: &[u8]| Payload::Frame(CanFrame::new(standard, data).unwrap());
    let remote = |word, length| Payload::Frame(CanFrame::of_word(word, None, length, &[]).unwrap());
    let fd = |bits, data: &[u8]| {
        Payload::Frame(CanFrame::fd(extended, FdFlags::from_bits(bits), data).unwrap())
    };
    let twelve: Vec<u8> = (0..12).collect();
    let short = [&twelve[..8], &[0; 4]].concat();
    let error = Payload::Error(ErrorFrame::BUS_ERROR);
    vec![
        entry(1_500_000, 0, tx, classic(&[1, 2, 3])),
        entry(1_500_001, 0, rx, remote(0x4000_0123, 2)),
        entry(1_500_002, 0, tx, classic(&[1, 2, 3])),
        entry(1_500_003, 1, tx, fd(3, &twelve)),
        entry(1_500_004, 1, rx, fd(0, &twelve)),
        entry(1_500_005, 1, rx, fd(0, &short)),
        entry(1_500_006, 1, rx, Payload::Frame(CanFrame::new(extended, &[0, 1, 2]).unwrap())),
        entry(1_500_007, 1, rx, remote(0xc000_1234, 8)),
        entry(1_500_009, 0, None, error),
        entry(1_500_010, 1, None, error),
        entry(1_500_011, 1, None, error),
    ]
}

#[test]
fn objects_of_vectors_tools_are_read_whichever_containers_they_cross() {
    for container in [1, 7, 64, 100, 10_000] {
        let (found, error) = read(Format::Blf, &file(&objects(), container));
        assert!(error.is_none(), "{error:?}");
        assert_eq!(found, entries(), "containers of {container} bytes");
    }
}

#[test]
fn what_other_objects_there_are_is_counted() {
    let mut bytes = file(&objects(), 100);
    // An object outside the containers.
    bytes.extend(object(65, 32, 2, 0, &[0; 8]));
    let path = std::path::Path::new("bus.blf");
    let input = std::io::Cursor::new(bytes);
    let mut reader = crate::LogReader::new(path, input, Format::Blf).unwrap();
    assert!(reader.by_ref().all(|entry| entry.is_ok()));
    // An event, a frame that is still to be sent, and the object outside.
    assert_eq!(reader.passed_over(), 3);
}

#[test]
fn our_objects_cross_containers_too() {
    let one = entries()[0];
    let many: Vec<_> = (0..6_000).map(|_| one).collect();
    let bytes = written(Format::Blf, &many);
    let containers = bytes.windows(4).filter(|four| four == b"LOBJ").count();
    assert_eq!(containers, 3, "6,000 objects of 48 bytes in containers of 128 KiB");
    let (found, error) = read(Format::Blf, &bytes);
    assert!(error.is_none() && found == many, "{error:?}");
    let size = u64::from_le_bytes(*bytes[16..].first_chunk().unwrap());
    assert_eq!(size, bytes.len() as u64);
}

#[test]
fn a_defect_has_its_place() {
    let message = |bytes: &[u8]| {
        let (_, error) = read(Format::Blf, bytes);
        let message = error.unwrap().to_string();
        message.split_once("bus.log as blf: ").unwrap().1.to_owned()
    };
    let with = |place: usize, byte: u8| {
        let mut bytes = file(&objects(), 10_000);
        bytes[place] = byte;
        message(&bytes)
    };
    let whole = file(&objects(), 10_000);
    let bad_time = object(1, 32, 1, u64::MAX, &[1; 16]);
    let late = object(1, 32, 2, i64::MAX as u64, &[1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    let text = [
        message(b"LOGG"),
        message(&whole[..150]),
        message(&whole[..whole.len() - 20]),
        with(4, 10),
        with(146, b'X'),
        with(152, 3),
        with(160, 1),
        with(144 + 32, b'X'),
        with(144 + 32 + 4, 3),
        with(144 + 32 + 8, 40),
        with(144 + 32 + 8, 3),
        with(144 + 32 + 32, 0),
        with(144 + 32 + 32 + 3, 16),
        with(144 + 32 + 32 + 5, 0x10),
        message(&file(&[bad_time], 100)),
        message(&file(&[late], 100)),
    ];
    insta::assert_snapshot!(text.join("\n"));
}
