//! Files with the layouts of other loggers: unsorted, with variable-length data, in lists, transposed, unfinished.

use super::samples::{read, written};
use crate::{Channel, Direction, Entry, ErrorFrame, Format, Payload};
use std::io::Write as _;
use wire::can::{CanFrame, FdFlags, StandardId};
use wire::time::Timestamp;

const BEGAN_NS: u64 = 1_506_783_973_191_000_000;

/// The blocks of a file, with the targets of links first.
pub(super) struct Blocks(Vec<u8>);

impl Blocks {
    pub(super) fn new() -> Self {
        let mut head = b"MDF     4.11    a logger".to_vec();
        head.resize(64 + 104, 0);
        head[28..30].copy_from_slice(&411u16.to_le_bytes());
        Self(head)
    }

    pub(super) fn put(&mut self, mark: &[u8; 4], links: &[u64], data: &[u8]) -> u64 {
        let address = self.0.len() as u64;
        let block = block(mark, links, data);
        self.0.extend(block);
        self.0.resize(self.0.len().next_multiple_of(8), 0);
        address
    }

    /// Name, kind of channel, data type, first byte and bit, bits, link.
    pub(super) fn channel(&mut self, next: u64, of: (&str, u8, u8, u32, u8, u32), at: u64) -> u64 {
        let (name, kind, number, byte, bit, bits) = of;
        let name = self.put(b"##TX", &[], format!("{name}\0").as_bytes());
        let mut data = vec![kind, u8::from(kind == 2), number, bit];
        data.extend(byte.to_le_bytes());
        data.extend(bits.to_le_bytes());
        data.resize(72, 0);
        self.put(b"##CN", &[next, 0, name, 0, 0, at, 0, 0], &data)
    }

    pub(super) fn group(
        &mut self,
        next: u64,
        channels: u64,
        number: u64,
        flags: u16,
        bytes: u32,
    ) -> u64 {
        let mut data = number.to_le_bytes().to_vec();
        data.extend([0; 8]);
        data.extend(flags.to_le_bytes());
        data.extend([0; 6]);
        data.extend(bytes.to_le_bytes());
        data.extend([0; 4]);
        self.put(b"##CG", &[next, channels, 0, 0, 0, 0], &data)
    }

    /// A frame's channels: time 8, bus and flags 1, identifier 4, data or their offset 8.
    pub(super) fn frames(&mut self, variable: Option<u64>) -> u64 {
        let (kind, number, at) = variable.map_or((0, 10, 0), |at| (1, 10, at));
        let data = self.channel(0, ("CAN_DataFrame.DataBytes", kind, number, 13, 0, 64), at);
        let length = self.channel(data, ("CAN_DataFrame.DataLength", 0, 0, 8, 4, 4), 0);
        let way = self.channel(length, ("CAN_DataFrame.Dir", 0, 0, 8, 3, 1), 0);
        let ide = self.channel(way, ("CAN_DataFrame.IDE", 0, 0, 8, 2, 1), 0);
        let bus = self.channel(ide, ("CAN_DataFrame.BusChannel", 0, 0, 8, 0, 2), 0);
        let id = self.channel(bus, ("CAN_DataFrame.ID", 0, 1, 9, 0, 32), 0);
        // Seconds as a floating-point number.
        self.channel(id, ("Timestamp", 2, 4, 0, 0, 64), 0)
    }

    pub(super) fn data_group(&mut self, groups: u64, data: u64, number_bytes: u8) -> u64 {
        self.put(b"##DG", &[0, groups, data, 0], &[number_bytes, 0, 0, 0, 0, 0, 0, 0])
    }

    /// The whole file.
    pub(super) fn file(mut self, first: u64) -> Vec<u8> {
        let header = block(
            b"##HD",
            &[first, 0, 0, 0, 0, 0],
            &[&BEGAN_NS.to_le_bytes()[..], &[0; 24]].concat(),
        );
        self.0[64..64 + 104].copy_from_slice(&header);
        self.0
    }
}

fn block(mark: &[u8; 4], links: &[u64], data: &[u8]) -> Vec<u8> {
    let mut bytes = mark.to_vec();
    bytes.extend([0; 4]);
    bytes.extend((24 + 8 * links.len() as u64 + data.len() as u64).to_le_bytes());
    bytes.extend((links.len() as u64).to_le_bytes());
    bytes.extend(links.iter().flat_map(|link| link.to_le_bytes()));
    bytes.extend(data);
    bytes
}

/// Bus 2, sent, standard identifier.
fn record(quarters: u32, id: u32, length: u8, data: [u8; 8]) -> Vec<u8> {
    let mut bytes = (f64::from(quarters) / 4.0).to_le_bytes().to_vec();
    bytes.push(0b1010 | length << 4);
    bytes.extend(id.to_be_bytes());
    bytes.extend(data);
    bytes
}

fn entry(quarters: i64, id: u16, data: &[u8]) -> Entry {
    let id = StandardId::new(id).unwrap();
    Entry {
        at: Timestamp::from_nanos(BEGAN_NS as i64 + quarters * 250_000_000),
        channel: Channel::numbered(1),
        direction: Some(Direction::Tx),
        payload: Payload::Frame(CanFrame::new(id, data).unwrap()),
    }
}

pub(super) fn entries() -> Vec<Entry> {
    vec![entry(1, 0x123, &[1, 2, 3]), entry(2, 0x7ff, &[]), entry(3, 0x124, &[9; 8])]
}

pub(super) fn records() -> Vec<Vec<u8>> {
    vec![
        record(1, 0x123, 3, [1, 2, 3, 0, 0, 0, 0, 0]),
        record(2, 0x7ff, 0, [0; 8]),
        record(3, 0x124, 8, [9; 8]),
    ]
}

fn compressed(bytes: &[u8], columns: u32) -> Vec<u8> {
    let mut deflated = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    deflated.write_all(bytes).unwrap();
    let deflated = deflated.finish().unwrap();
    let mut data = b"DT".to_vec();
    data.extend([u8::from(columns > 0), 0]);
    data.extend(columns.to_le_bytes());
    data.extend((bytes.len() as u64).to_le_bytes());
    data.extend((deflated.len() as u64).to_le_bytes());
    data.extend(deflated);
    data
}

fn sorted(data: impl Fn(&mut Blocks) -> u64) -> Vec<u8> {
    let mut blocks = Blocks::new();
    let channels = blocks.frames(None);
    let group = blocks.group(0, channels, 0, 6, 21);
    let data = data(&mut blocks);
    let first = blocks.data_group(group, data, 0);
    blocks.file(first)
}

#[track_caller]
fn assert_read(bytes: &[u8], expected: &[Entry]) {
    let (found, error) = read(Format::Mdf4, bytes);
    assert!(error.is_none(), "{error:?}");
    assert_eq!(found, expected);
}

#[test]
fn data_are_in_blocks_lists_and_compressed() {
    let all = records().concat();
    assert_read(&sorted(|blocks| blocks.put(b"##DT", &[], &all)), &entries());
    assert_read(&sorted(|blocks| blocks.put(b"##DZ", &[], &compressed(&all, 0))), &entries());
    // Two rows of 25 columns, and a rest.
    let mut transposed: Vec<u8> = (0..25).flat_map(|at| [all[at], all[25 + at]]).collect();
    transposed.extend(&all[50..]);
    let transposed = compressed(&transposed, 25);
    assert_read(&sorted(|blocks| blocks.put(b"##DZ", &[], &transposed)), &entries());
    // Blocks that end within a record, and a missing one.
    let lists = sorted(|blocks| {
        let one = blocks.put(b"##DT", &[], &all[..30]);
        let two = blocks.put(b"##DZ", &[], &compressed(&all[30..33], 0));
        let three = blocks.put(b"##DT", &[], &all[33..]);
        let last = blocks.put(b"##DL", &[0, three], &[0; 24]);
        let first = blocks.put(b"##DL", &[last, one, 0, two], &[0; 40]);
        blocks.put(b"##HL", &[first], &[0; 8])
    });
    assert_read(&lists, &entries());
    assert_read(&sorted(|_| 0), &[]);
}

#[test]
fn data_bytes_are_among_signal_data() {
    let mut blocks = Blocks::new();
    let data = [&[3, 0, 0, 0, 1, 2, 3][..], &[0; 4], &[8, 0, 0, 0], &[9; 8]].concat();
    let data = blocks.put(b"##SD", &[], &data);
    let channels = blocks.frames(Some(data));
    let group = blocks.group(0, channels, 0, 6, 21);
    let place = |place: u64| place.to_le_bytes();
    let records = [
        record(1, 0x123, 3, place(0)),
        record(2, 0x7ff, 0, place(7)),
        record(3, 0x124, 8, place(11)),
        // The same value again.
        record(4, 0x124, 8, place(11)),
    ];
    let data = blocks.put(b"##DT", &[], &records.concat());
    let first = blocks.data_group(group, data, 0);
    let mut expected = entries();
    expected.push(entry(4, 0x124, &[9; 8]));
    assert_read(&blocks.file(first), &expected);
}

/// A group of frames, a variable-length group with their data, and another group.
fn unsorted(order: impl Fn(&[Vec<u8>], &[Vec<u8>]) -> Vec<u8>) -> Vec<u8> {
    let mut blocks = Blocks::new();
    let variable = blocks.group(0, 0, 2, 1, 0);
    let other = blocks.group(variable, 0, 3, 0, 5);
    let channels = blocks.frames(Some(variable));
    let group = blocks.group(other, channels, 1, 6, 21);
    let place = |place: u64| place.to_le_bytes();
    let frames = [
        [vec![1], record(1, 0x123, 3, place(0))].concat(),
        [vec![1], record(2, 0x7ff, 0, place(7))].concat(),
        [vec![1], record(3, 0x124, 8, place(11))].concat(),
    ];
    let data = [
        vec![2, 3, 0, 0, 0, 1, 2, 3],
        vec![2, 0, 0, 0, 0],
        [vec![2, 8, 0, 0, 0], vec![9; 8]].concat(),
    ];
    let data = blocks.put(b"##DT", &[], &order(&frames, &data));
    let first = blocks.data_group(group, data, 1);
    blocks.file(first)
}

#[test]
fn records_of_several_groups_are_told_apart_by_their_numbers() {
    let other = vec![3, 0, 0, 0, 0, 0];
    let behind = unsorted(|frames, data| {
        let each = frames.iter().zip(data);
        each.flat_map(|(frame, data)| [frame.clone(), other.clone(), data.clone()].concat())
            .collect()
    });
    assert_read(&behind, &entries());
    let before = unsorted(|frames, data| [data.concat(), other.clone(), frames.concat()].concat());
    assert_read(&before, &entries());
    let (found, error) = read(Format::Mdf4, &unsorted(|frames, _| frames.concat()));
    assert!(found.is_empty());
    let message = error.unwrap().to_string();
    assert!(
        message.ends_with("expected data bytes for every frame, found `their end`"),
        "{message}"
    );
}

#[test]
fn a_file_that_was_not_finished_goes_to_its_end() {
    let all = records().concat();
    let mut bytes = sorted(|blocks| {
        let place = blocks.put(b"##DT", &[], &[]);
        blocks.0.extend(&all);
        place
    });
    // The data must be the last block of such a file.
    let (place, end) = (bytes.windows(4).position(|four| four == b"##DT").unwrap(), bytes.len());
    let group = bytes.split_off(place + 24 + all.len());
    let mut moved = Blocks(bytes.split_off(place));
    bytes.extend(group);
    let moved_to = bytes.len() as u64;
    bytes.append(&mut moved.0);
    assert_eq!(bytes.len(), end);
    // The data group, which links to the data, is now before them.
    let data_group = bytes.windows(4).position(|four| four == b"##DG").unwrap();
    bytes[data_group + 24 + 16..][..8].copy_from_slice(&moved_to.to_le_bytes());
    bytes[64 + 24..][..8].copy_from_slice(&(data_group as u64).to_le_bytes());
    bytes[..8].copy_from_slice(b"UnFinMF ");
    bytes[60] = 5;
    assert_read(&bytes, &entries());
    bytes[60] = 0x40;
    let (_, error) = read(Format::Mdf4, &bytes);
    let message = error.unwrap().to_string();
    assert!(message.ends_with("expected a file that its logger finished, found `flags 0x0040`"));
}

#[test]
fn a_block_that_is_cut_is_read_up_to_there() {
    let all = records().concat();
    let whole = sorted(|blocks| blocks.put(b"##DT", &[], &all));
    let place = whole.windows(4).position(|four| four == b"##DT").unwrap();
    let group = whole[place..].windows(4).position(|four| four == b"##DG").unwrap();
    let mut bytes = whole.clone();
    // The data are last.
    let block = bytes.drain(place..place + group).collect::<Vec<u8>>();
    let (data_group, data) = (place as u64, bytes.len() as u64);
    bytes.extend(block);
    bytes[64 + 24..][..8].copy_from_slice(&data_group.to_le_bytes());
    bytes[place + 24 + 16..][..8].copy_from_slice(&data.to_le_bytes());
    assert_read(&bytes, &entries());
    let (found, error) = read(Format::Mdf4, &bytes[..data as usize + 24 + 2 * all.len() / 3 + 5]);
    assert_eq!(found, entries()[..2]);
    assert!(miette::Diagnostic::help(&error.unwrap()).unwrap().to_string().contains("2 entries"));
}

#[test]
fn a_defect_has_its_place() {
    let all = records().concat();
    let message = |bytes: &[u8]| {
        let (_, error) = read(Format::Mdf4, bytes);
        let message = error.map_or_else(|| "nothing".to_owned(), |error| error.to_string());
        message.replace("failed to read bus.log as mdf4: ", "")
    };
    let whole = sorted(|blocks| blocks.put(b"##DT", &[], &all));
    let with = |mark: &[u8; 4], place: usize, bytes: &[u8]| {
        let mut whole = whole.clone();
        let at = whole.windows(4).position(|four| four == mark).unwrap() + place;
        whole[at..at + bytes.len()].copy_from_slice(bytes);
        message(&whole)
    };
    let circle = sorted(|blocks| {
        let place = blocks.0.len() as u64;
        blocks.put(b"##DL", &[place], &[0; 8])
    });
    let mut short = compressed(&all, 0);
    short[8] += 1;
    let text = [
        message(b"MDF     3.30"),
        message(&whole[..100]),
        message(&whole[..1_780]),
        with(b"MDF ", 28, &[0x4a, 1]),
        with(b"##HD", 24, &[1]),
        with(b"##HD", 31, &[0x7f]),
        with(b"##HD", 72, &[0xff; 8]),
        with(b"##DG", 8, &[23]),
        with(b"##DG", 56, &[3]),
        with(b"##CG", 96, &[7]),
        with(b"##CN", 72 + 16 + 8, &[65]),
        with(b"##DT", 0, b"##XX"),
        with(b"##DT", 8, &[24 + 20]),
        with(b"##DT", 24, &f64::NAN.to_le_bytes()),
        with(b"##DT", 24 + 9, &[0, 0, 8, 0]),
        with(b"##DT", 24 + 8, &[0xfa]),
        message(&circle),
        message(&sorted(|blocks| blocks.put(b"##DZ", &[], &short))),
        message(&sorted(|blocks| blocks.put(b"##DZ", &[], b"DT\x02\0\0\0\0\0"))),
    ];
    insta::assert_snapshot!(text.join("\n"));
}

#[test]
fn our_groups_have_lists_of_blocks() {
    let id = StandardId::new(1).unwrap();
    let fd = CanFrame::fd(id, FdFlags::from_bits(1), &[7; 64]).unwrap();
    let entry = |number: i64, payload| Entry {
        at: Timestamp::from_nanos(BEGAN_NS as i64 + number),
        channel: Channel::CAN0,
        direction: (!matches!(payload, Payload::Error(_))).then_some(Direction::Rx),
        payload,
    };
    // More than one list of 64 blocks of 4,096 error frames, which are the shortest.
    let error = Payload::Error(ErrorFrame::BUS_ERROR);
    let mut entries: Vec<_> = (0..270_000).map(|number| entry(number, error)).collect();
    // At the same time frames come first.
    entries.insert(5_000, entry(5_000, Payload::Frame(fd)));
    entries.push(entry(2_000_000, Payload::Frame(fd)));
    let bytes = written(Format::Mdf4, &entries);
    let lists = bytes.windows(4).filter(|four| four == b"##DL").count();
    assert_eq!(lists, 3, "two of error frames, one of frames");
    assert_read(&bytes, &entries);
}
