//! Tests of changed and truncated files.

use super::super::blocks::BLOCK_BYTES;
use super::{END_BYTES, header, one_of_each, read, reader, written};
use crate::reader::RecordError;
use crate::sink::{FileSink, Level, RecordSink};
use crate::{Device, Record, RecordKind};
use proptest::prelude::*;
use std::io::{self, Write};
use std::sync::{Arc, Mutex};
use wire::time::Timestamp;

/// A record of format 2, written by the version of that time.
const FORMAT_2: &[u8] = include_bytes!("format-2.hilrec");

/// Enough records for several blocks.
fn long() -> Vec<Record> {
    let note = |index: usize| Record {
        at: Timestamp::from_nanos(1_000 * index as i64),
        device: Device::Plan,
        kind: RecordKind::Note(format!("note {index} {}", "x".repeat(index % 300))),
    };
    (0..4 * BLOCK_BYTES / 150).map(note).collect()
}

/// The error that reveals a change; `None` if it goes unnoticed.
fn noticed(file: &[u8]) -> Option<RecordError> {
    match reader(file) {
        Ok(records) => records.into_iter().find_map(Result::err),
        Err(error) => Some(error),
    }
}

/// Whether the error locates this byte: it names its block or a place before it.
fn leads_to(error: &RecordError, place: usize) -> bool {
    match error {
        RecordError::NotARecord
        | RecordError::NewerFormat { .. }
        | RecordError::OlderFormat { .. }
        | RecordError::HeaderTooLong { .. }
        | RecordError::HeaderCutShort
        | RecordError::HeaderDamaged { .. } => true,
        RecordError::Damaged { offset, .. } | RecordError::CutShort { offset, .. } => {
            place as u64 + (2 * BLOCK_BYTES) as u64 > *offset && *offset <= place as u64
        }
        _ => false,
    }
}

#[test]
fn every_flipped_bit_of_a_short_record_is_noticed() {
    let mut file = written(&one_of_each());
    assert!(noticed(&file).is_none());
    let version = 8..10;
    for bit in 0..8 * file.len() {
        let place = bit / 8;
        file[place] ^= 1 << (bit % 8);
        let error = noticed(&file);
        // A file that passes as format 2 has no checksums; its first record gives it away.
        let error = error.filter(|error| version.contains(&place) || leads_to(error, place));
        assert!(error.is_some(), "bit {} of byte {place}: {:?}", bit % 8, noticed(&file));
        file[place] ^= 1 << (bit % 8);
    }
}

#[test]
fn a_block_that_is_missing_or_moved_is_noticed() {
    let seen = Seen::default();
    let mut sink = FileSink::new(seen.clone(), &header(), Level::Full).unwrap();
    // Without a flush the file grows by whole blocks.
    let mut ends = vec![seen.length()];
    for record in long() {
        sink.record(record);
        if Some(&seen.length()) != ends.last() {
            ends.push(seen.length());
        }
    }
    sink.finish();
    let file = written(&long());
    assert!(ends.len() > 3, "{ends:?}");
    let missing = [&file[..ends[1]], &file[ends[2]..]].concat();
    assert!(
        matches!(noticed(&missing), Some(RecordError::Damaged { offset, .. }) if offset as usize == ends[1])
    );
    let moved =
        [&file[..ends[0]], &file[ends[1]..ends[2]], &file[ends[0]..ends[1]], &file[ends[2]..]]
            .concat();
    assert!(
        matches!(noticed(&moved), Some(RecordError::Damaged { offset, .. }) if offset as usize == ends[0])
    );
}

proptest! {
    #[test]
    fn a_flipped_bit_of_a_long_record_is_noticed_in_its_block(bit in any::<prop::sample::Index>()) {
        let records = long();
        let mut file = written(&records);
        let header = written(&[]).len() - END_BYTES;
        let place = header + bit.index(8 * (file.len() - header)) / 8;
        file[place] ^= 1 << (bit.index(8 * (file.len() - header)) % 8);
        let (back, error) = read(&file);
        prop_assert_eq!(&back[..], &records[..back.len()], "what is handed over is right");
        prop_assert!(error.as_ref().is_some_and(|error| leads_to(error, place)), "{place}: {error:?}");
    }
}

#[test]
fn a_record_of_format_2_is_read_to_its_end() {
    let mut reader = reader(FORMAT_2).unwrap();
    assert_eq!(reader.header().plan, "plan");
    let count = reader.by_ref().map(Result::unwrap).count();
    assert!(count > 10, "{count}");
    let (records, error) = read(&FORMAT_2[..FORMAT_2.len() - 1]);
    assert_eq!(records.len(), count);
    assert!(matches!(error, Some(RecordError::CutShort { trailing: 0, .. })), "{error:?}");
    let (records, error) = read(&FORMAT_2[..FORMAT_2.len() - 2]);
    assert_eq!(records.len(), count - 1);
    assert!(matches!(error, Some(RecordError::CutShort { .. })), "{error:?}");
    let longer = [FORMAT_2, &[0]].concat();
    assert!(matches!(read(&longer).1, Some(RecordError::Damaged { .. })));
}

/// A file that can be inspected while it is written.
#[derive(Debug, Clone, Default)]
struct Seen(Arc<Mutex<Vec<u8>>>);

impl Seen {
    fn length(&self) -> usize {
        self.0.lock().unwrap().len()
    }
}

impl Write for Seen {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap().extend(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn what_was_flushed_is_there_and_the_file_comes_out_the_same() {
    let file = Seen::default();
    let mut sink = FileSink::new(file.clone(), &header(), Level::Full).unwrap();
    let records = long();
    for (index, record) in records.iter().enumerate() {
        sink.record(record.clone());
        if index % 7 == 0 {
            sink.flush();
            let (back, error) = read(&file.0.lock().unwrap());
            assert_eq!(back.len(), index + 1);
            assert!(matches!(error, Some(RecordError::CutShort { trailing: 0, .. })), "{error:?}");
        }
    }
    sink.finish();
    assert!(*file.0.lock().unwrap() == written(&records), "the same bytes as without a flush");
}
