//! Measured channels: written ones can be read, and so can those with other layouts.

use super::mdf4::Blocks;
use crate::LogError;
use crate::mdf4::channels::{Cell, Form, Kind, Reader, Value, Wanted, Writer};
use std::io::Cursor;
use std::path::Path;

fn path() -> &'static Path {
    Path::new("values.mf4")
}

fn form(name: &str, kind: Kind, unit: &str) -> Form {
    let (name, unit, doc) = (name.to_owned(), unit.to_owned(), format!("what {name} is"));
    Form { name, kind, unit, doc, names: Vec::new() }
}

/// A file of two groups, the second with this number of records for each kind of channel.
fn written(records: u32) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let mut writer = Writer::new(path(), &mut file).unwrap();
    let time = || form("time", Kind::Float, "s");
    let small = writer.group("small", "", vec![time(), form("x", Kind::Integer, "m")]);
    let mut state = form("state", Kind::Float, "");
    state.names = vec![(0.0, "off".to_owned()), (1.0, "on".to_owned())];
    let channels = vec![
        time(),
        form("rate", Kind::Float, "deg/s"),
        form("moving", Kind::Bool, ""),
        form("word", Kind::Choice, ""),
        form("note", Kind::Text, ""),
        state,
    ];
    let large = writer.group("large", "of all kinds", channels);
    for n in 0..records {
        let at = Value::Float(f64::from(n) / 100.0);
        let note = format!("note {n}");
        writer.record(large, &record(at, n, &note)).unwrap();
        if n % 100 == 0 {
            writer.record(small, &[at, Value::Integer(-i64::from(n))]).unwrap();
        }
    }
    writer.finish(&[("plan", "a <plan>".to_owned())]).unwrap();
    file.into_inner()
}

fn record<'a>(at: Value<'a>, n: u32, note: &'a str) -> [Value<'a>; 6] {
    if n % 7 == 3 {
        let gone = Value::Missing;
        return [at, gone, gone, gone, gone, gone];
    }
    let word = if n.is_multiple_of(2) { "even" } else { "odd" };
    [
        at,
        Value::Float(f64::from(n) * 0.1),
        Value::Bool(n.is_multiple_of(3)),
        Value::Text(word),
        Value::Text(note),
        Value::Float(f64::from(n % 3)),
    ]
}

/// The cells of a group, with those channels as texts.
fn read(bytes: &[u8], group: &str, texts: &[usize]) -> Result<Vec<Vec<Cell>>, LogError> {
    let mut reader = Reader::new(path(), Cursor::new(bytes))?;
    let place = reader.groups().iter().position(|one| one.name == group).unwrap();
    let channels = 0..reader.groups()[place].channels.len();
    let wanted: Vec<_> =
        channels.map(|channel| Wanted { channel, as_text: texts.contains(&channel) }).collect();
    let mut cells = Vec::new();
    let found = reader.read(place, &wanted, &mut |row| {
        cells.push(row);
        Ok::<_, LogError>(())
    })?;
    assert_eq!(found.records, cells.len() as u64);
    Ok(cells)
}

#[test]
fn what_is_written_is_read() {
    // Several hundred blocks: more than one list of them.
    let records = 200_000;
    let bytes = written(records);
    let reader = Reader::new(path(), Cursor::new(&bytes)).unwrap();
    let [small, large] = reader.groups() else { panic!("{:?}", reader.groups()) };
    assert_eq!((small.name.as_str(), small.records), ("small", u64::from(records / 100)));
    assert_eq!(large.records, u64::from(records));
    let of = |name: &str| large.channels.iter().find(|channel| channel.name == name).unwrap();
    assert!(of("time").is_time && !of("rate").is_time);
    assert_eq!(of("rate").unit, "deg/s");
    let cells = read(&bytes, "large", &[3, 4, 5]).unwrap();
    for (n, found) in (0..records).zip(&cells) {
        let note = format!("note {n}");
        let given = record(Value::Float(f64::from(n) / 100.0), n, &note);
        let expected = given.iter().enumerate().map(|(channel, value)| match value {
            Value::Missing => Cell::Missing,
            Value::Float(0.0) if channel == 5 => Cell::Text("off".to_owned()),
            Value::Float(1.0) if channel == 5 => Cell::Text("on".to_owned()),
            Value::Float(number) => Cell::Number(*number),
            Value::Integer(number) => Cell::Number(*number as f64),
            Value::Bool(yes) => Cell::Number(f64::from(u8::from(*yes))),
            Value::Text(text) => Cell::Text((*text).to_owned()),
        });
        assert!(expected.eq(found.iter().cloned()), "{n}: {found:?}");
    }
    let numbers = read(&bytes, "small", &[]).unwrap();
    assert_eq!(numbers[3], [Cell::Number(3.0), Cell::Number(-300.0)]);
    assert_eq!(bytes, written(records), "the same values are the same bytes");
}

#[test]
fn a_file_that_was_cut_or_changed_is_an_error_by_its_place() {
    let bytes = written(300);
    // The descriptions follow the data, with the first group last; only comments follow that.
    let last = bytes.windows(4).rposition(|mark| mark == b"##DG").unwrap();
    for length in (0..last).step_by(61) {
        let error = Reader::new(path(), Cursor::new(&bytes[..length])).err();
        assert!(error.is_some(), "{length} of {} bytes", bytes.len());
    }
    // A damaged data block no longer decompresses.
    let place = bytes.windows(4).position(|mark| mark == b"##DZ").unwrap();
    let mut damaged = bytes.clone();
    damaged[place + 60] ^= 0xff;
    let error = ["small", "large"].map(|group| read(&damaged, group, &[3, 4]).err());
    let error = error.into_iter().flatten().next().unwrap().to_string();
    assert!(error.contains(&format!("block at byte {place}")), "{error}");
}

/// Type, data type, first byte and bit, bits, conversion.
fn channel(blocks: &mut Blocks, next: u64, name: &str, of: (u8, u8, u32, u8, u32, u64)) -> u64 {
    let (kind, number, byte, bit, bits, conversion) = of;
    let name = blocks.put(b"##TX", &[], format!("{name}\0").as_bytes());
    let mut data = vec![kind, u8::from(kind == 2), number, bit];
    data.extend(byte.to_le_bytes());
    data.extend(bits.to_le_bytes());
    data.resize(72, 0);
    blocks.put(b"##CN", &[next, 0, name, 0, conversion, 0, 0, 0], &data)
}

fn conversion(blocks: &mut Blocks, kind: u8, values: &[f64]) -> u64 {
    let mut data = vec![kind, 0, 0, 0, 0, 0];
    data.extend((values.len() as u16).to_le_bytes());
    data.extend([0; 16]);
    data.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    blocks.put(b"##CC", &[0, 0, 0, 0], &data)
}

/// Records of 15 bytes: time in ms 4, a big-endian 12-bit number from bit 4 of two bytes, a signed big-endian 24-bit
/// number, a single, and a text of two bytes; among those of another group, each after its record number.
fn foreign(count: u32) -> Vec<u8> {
    let mut data = Vec::new();
    for n in 0..count {
        data.push(1);
        data.extend((n * 10).to_le_bytes());
        data.extend((((n as u16) << 4) | 0xf).to_be_bytes());
        data.extend(&(-(n as i32)).to_be_bytes()[1..]);
        data.extend((n as f32 / 4.0).to_be_bytes());
        data.extend(if n.is_multiple_of(2) { b"ab" } else { b"c\0" });
        if n.is_multiple_of(3) {
            data.extend([2, 9, 9, 9]);
        }
    }
    data
}

fn file_of(mut blocks: Blocks, count: u32, at: u64) -> Vec<u8> {
    let milliseconds = conversion(&mut blocks, 1, &[0.0, 0.001]);
    let halves = conversion(&mut blocks, 2, &[0.0, 0.5, 1.0, 0.0, 0.0, 1.0]);
    let text = channel(&mut blocks, 0, "text", (0, 7, 13, 0, 16, 0));
    let single = channel(&mut blocks, text, "single", (0, 5, 9, 0, 32, 0));
    let signed = channel(&mut blocks, single, "signed", (0, 3, 6, 0, 24, 0));
    let bits = channel(&mut blocks, signed, "bits", (0, 1, 4, 4, 12, halves));
    let time = channel(&mut blocks, bits, "t", (2, 0, 0, 0, 32, milliseconds));
    let other = channel(&mut blocks, 0, "other", (0, 0, 0, 0, 8, 0));
    let other = blocks.group(0, other, 2, 0, 3);
    let group = blocks.group(other, time, 1, 0, 15);
    let first = blocks.data_group(group, at, 1);
    let mut bytes = blocks.file(first);
    // Counts of records, which are valid in a finished file.
    bytes[group as usize + 24 + 48 + 8..][..8].copy_from_slice(&u64::from(count).to_le_bytes());
    let others = u64::from(count.div_ceil(3));
    bytes[other as usize + 24 + 48 + 8..][..8].copy_from_slice(&others.to_le_bytes());
    bytes
}

/// Contents of record `n` in the first group of [`foreign`].
fn expected(n: u32) -> [Cell; 5] {
    let n = f64::from(n);
    [
        Cell::Number(n * 10.0 * 0.001),
        Cell::Number(0.5 * n + 1.0),
        Cell::Number(-n),
        Cell::Number(n / 4.0),
        Cell::Text(if n % 2.0 == 0.0 { "ab" } else { "c" }.to_owned()),
    ]
}

fn is_expected(cells: &[Vec<Cell>]) -> bool {
    (0..).zip(cells).all(|(n, found)| *found == expected(n))
}

#[test]
fn numbers_of_any_size_and_order_are_read_among_other_records() {
    let (mut blocks, data) = (Blocks::new(), foreign(50));
    let at = blocks.put(b"##DT", &[], &data);
    let bytes = file_of(blocks, 50, at);
    // Neither group has a name, so this is the first.
    let cells = read(&bytes, "", &[4]).unwrap();
    assert!(cells.len() == 50 && is_expected(&cells), "{cells:?}");
    let error = read(&bytes, "", &[]).unwrap_err().to_string();
    assert!(error.contains("expected a channel of numbers, found `texts`"), "{error}");
}

#[test]
fn of_an_unfinished_file_comes_what_is_there() {
    let data = foreign(50);
    // All relevant blocks precede the data, as a logger writes them.
    let at = file_of(Blocks::new(), 0, 0).len() as u64;
    let mut bytes = file_of(Blocks::new(), 0, at);
    assert_eq!(bytes.len() as u64, at);
    bytes.extend(b"##DT\0\0\0\0");
    bytes.extend((24 + data.len() as u64).to_le_bytes());
    bytes.extend([0; 8]);
    bytes.extend(&data[..data.len() - 7]);
    let error = read(&bytes, "", &[4]).unwrap_err().to_string();
    assert!(error.contains(&format!("block at byte {at}")), "{error}");
    bytes[..8].copy_from_slice(b"UnFinMF ");
    bytes[60] = 1;
    let cells = read(&bytes, "", &[4]).unwrap();
    assert!(cells.len() == 49 && is_expected(&cells), "{}", cells.len());
    let mut reader = Reader::new(path(), Cursor::new(&bytes)).unwrap();
    assert!(reader.is_unfinished());
    let found = reader.read(0, &[], &mut |_| Ok::<_, LogError>(())).unwrap();
    let ended = found.ended.unwrap().to_string();
    assert!(ended.contains("expected a whole record"), "{ended}");
}
