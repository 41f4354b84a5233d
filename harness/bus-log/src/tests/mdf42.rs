//! Files of MDF 4.2 with a block for each channel, and files with many groups.

use super::mdf4::{Blocks, entries, records};
use super::samples::read;
use crate::Format;
use crate::mdf4::channels::Reader;
use std::io::Cursor;

const REMOTE_MASTER: u16 = 1 << 3;
const FRAMES: u16 = 6;

/// A file of one group with these flags, and data in a block with this mark.
fn file(flags: u16, mark: &[u8; 4]) -> Vec<u8> {
    let mut blocks = Blocks::new();
    let channels = blocks.frames(None);
    let group = blocks.group(0, channels, 0, flags, 21);
    let data = blocks.put(mark, &[], &records().concat());
    let first = blocks.data_group(group, data, 0);
    blocks.file(first)
}

#[test]
fn column_oriented_storage_is_refused_by_its_name() {
    for bytes in
        [file(FRAMES, b"##DV"), file(FRAMES, b"##LD"), file(FRAMES | REMOTE_MASTER, b"##DT")]
    {
        let (_, error) = read(Format::Mdf4, &bytes);
        let error = error.unwrap().to_string();
        assert!(error.contains("column-oriented storage of MDF 4.2"), "{error}");
    }
    let channels = Reader::new("values.mf4".as_ref(), Cursor::new(file(REMOTE_MASTER, b"##DV")));
    let error = channels.unwrap_err().to_string();
    assert!(error.contains("column-oriented storage of MDF 4.2"), "{error}");
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
