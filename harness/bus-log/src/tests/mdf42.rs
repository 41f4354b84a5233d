//! Files of MDF 4.2 with a block for each channel, and files with many groups.

use super::mdf4::{Blocks, entries, records};
use super::samples::read;
use crate::mdf4::channels::{Cell, Reader, Wanted};
use crate::{Format, LogError};
use std::io::Cursor;

const REMOTE_MASTER: u16 = 1 << 3;
const FRAMES: u16 = 6;

/// Flag of a list: values and invalidation bits are in blocks of their own.
const APART: u32 = 1 << 31;

/// A file of frames with these flags, in two blocks of values that a list with these flags links to.
fn frames(flags: u16, list_flags: u32) -> Vec<u8> {
    let mut blocks = Blocks::new();
    let channels = blocks.frames(None);
    let group = blocks.group(0, channels, 0, flags, 21);
    let data = list(&mut blocks, &records(), &records(), list_flags);
    let first = blocks.data_group(group, data, 0);
    blocks.file(first)
}

/// Values in two blocks, and as many of invalidation bits.
fn list(blocks: &mut Blocks, values: &[Vec<u8>], invalid: &[Vec<u8>], flags: u32) -> u64 {
    let mut links = vec![0];
    let kinds: [(&[u8; 4], &[Vec<u8>]); 2] = [(b"##DV", values), (b"##DI", invalid)];
    for (mark, records) in &kinds[..1 + usize::from(flags & APART != 0)] {
        let (first, rest) = records.split_at(1);
        links.push(blocks.put(mark, &[], &first.concat()));
        links.push(blocks.put(mark, &[], &rest.concat()));
    }
    let mut data = [flags, 2].map(u32::to_le_bytes).concat();
    data.extend([0; 16]);
    blocks.put(b"##LD", &links, &data)
}

#[test]
fn frames_may_be_in_blocks_of_values_and_not_apart_from_their_times() {
    let (found, error) = read(Format::Mdf4, &frames(FRAMES, 0));
    assert!(error.is_none() && found == entries(), "{error:?}");
    for (bytes, said) in [
        (frames(FRAMES | REMOTE_MASTER, 0), "column-oriented frames of MDF 4.2 are not read"),
        (frames(FRAMES, APART), "in MDF 4.2 apart from them"),
    ] {
        let (_, error) = read(Format::Mdf4, &bytes);
        let error = error.unwrap().to_string();
        assert!(error.contains(said), "{error}");
    }
}

/// Times in one group, `x` in another, one of whose values is missing; `records` of `x` are promised.
fn columns(records: u64, master_is_there: bool) -> Vec<u8> {
    let mut blocks = Blocks::new();
    let group = |blocks: &mut Blocks, channels, flags: u16, invalid: u32, count: u64, master| {
        let mut data = [0u64, count].map(u64::to_le_bytes).concat();
        data.extend(u64::from(flags).to_le_bytes());
        data.extend([8, invalid].map(u32::to_le_bytes).concat());
        blocks.put(b"##CG", &[0, channels, 0, 0, 0, 0, master], &data)
    };
    let column = |values: [f64; 3]| values.map(|value| value.to_le_bytes().to_vec());
    let time = blocks.channel(0, ("t", 2, 4, 0, 0, 64), 0);
    let times = group(&mut blocks, time, 0, 0, 3, 0);
    let name = blocks.put(b"##TX", &[], b"x\0");
    // A fixed number of 64 bits, missing where bit 1 is set.
    let of_channel = [4 << 16, 0, 64, 1 << 1, 1].map(u32::to_le_bytes).concat();
    let x = blocks.put(b"##CN", &[0, 0, name, 0, 0, 0, 0, 0], &[of_channel, vec![0; 52]].concat());
    let master = if master_is_there { times } else { 64 };
    let xs = group(&mut blocks, x, REMOTE_MASTER, 1, records, master);
    let bits = [0u8, 2, 0].map(|bits| vec![bits]);
    let data = list(&mut blocks, &column([5.0, 6.0, 7.0]), &bits, APART);
    let xs = blocks.data_group(xs, data, 0);
    let data = list(&mut blocks, &column([0.5, 1.5, 2.5]), &[], 0);
    let first = blocks.put(b"##DG", &[xs, times, data, 0], &[0; 8]);
    blocks.file(first)
}

#[test]
fn columns_are_read_with_their_times() {
    let mut file = Reader::new("values.mf4".as_ref(), Cursor::new(columns(3, true))).unwrap();
    let [group] = file.groups() else { panic!("{:?}", file.groups()) };
    let names: Vec<_> = group.channels.iter().map(|one| (one.name.as_str(), one.is_time)).collect();
    assert_eq!(names, [("t", true), ("x", false)]);
    let wanted = [1, 0].map(|channel| Wanted { channel, as_text: false });
    let mut rows = Vec::new();
    let found = file.read(0, &wanted, &mut |row| {
        rows.push(row);
        Ok::<_, LogError>(())
    });
    assert_eq!(found.unwrap().records, 3);
    let row = |x, t| vec![x, Cell::Number(t)];
    assert_eq!(
        rows,
        [row(Cell::Number(5.0), 0.5), row(Cell::Missing, 1.5), row(Cell::Number(7.0), 2.5)]
    );
    for damaged in [columns(4, true), columns(3, false)] {
        let error = Reader::new("values.mf4".as_ref(), Cursor::new(damaged)).unwrap_err();
        assert!(error.to_string().contains("a group with as many times"), "{error}");
    }
}

/// As a logger writes them that has a group for each message of a DBC.
#[test]
fn a_file_may_have_thousands_of_groups() {
    const GROUPS: usize = 10_000;
    let mut blocks = Blocks::new();
    let channels = blocks.frames(None);
    let frames = blocks.group(0, channels, 0, FRAMES, 21);
    let data = blocks.put(b"##DT", &[], &records().concat());
    let other = blocks.group(0, 0, 0, 0, 8);
    let mut next = blocks.data_group(frames, data, 0);
    for _ in 0..GROUPS {
        next = blocks.put(b"##DG", &[next, other, 0, 0], &[0; 8]);
    }
    let bytes = blocks.file(next);
    let (found, error) = read(Format::Mdf4, &bytes);
    assert!(error.is_none() && found == entries(), "{error:?}");
    let channels = Reader::new("values.mf4".as_ref(), Cursor::new(bytes)).unwrap();
    assert_eq!(channels.groups().len(), GROUPS + 1);
}
