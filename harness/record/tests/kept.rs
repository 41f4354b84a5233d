//! The record on disk is never more than a second behind, and a broken property is written to it at once.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use record::header::Header;
use record::run_folder::RunFolder;
use record::sink::{Level, RecordSink};
use record::{Device, Record, RecordKind, Violation};
use std::sync::mpsc;
use std::time::Duration;
use wire::time::Timestamp;

const NOTES: usize = 10;

/// A sink with a few notes, long before a block is full or anything else flushes it.
fn noted(folder: &RunFolder) -> impl RecordSink + use<> {
    let mut sink = folder.record_sink(&Header::default(), Level::Full).unwrap();
    for index in 0..NOTES {
        let at = Timestamp::from_nanos(index as i64);
        sink.record(Record { at, device: Device::Plan, kind: RecordKind::Note("told".into()) });
    }
    sink
}

fn on_disk(folder: &RunFolder) -> usize {
    folder.records().unwrap().filter(Result::is_ok).count()
}

#[test]
fn what_was_recorded_is_on_disk_within_a_second_while_nothing_happens() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = RunFolder::create(temporary.path().join("run")).unwrap();
    let sink = noted(&folder);
    let (_nobody, never) = mpsc::channel::<()>();
    let step = Duration::from_millis(50);
    let mut waited = Duration::ZERO;
    while on_disk(&folder) < NOTES {
        assert!(waited < Duration::from_secs(1), "{} records after {waited:?}", on_disk(&folder));
        let _ = never.recv_timeout(step);
        waited += step;
    }
    drop(sink);
}

#[test]
fn a_property_that_breaks_is_on_disk_at_once() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = RunFolder::create(temporary.path().join("run")).unwrap();
    let mut sink = noted(&folder);
    let violation = Violation { at: Timestamp::ZERO, what: "it moves".into() };
    sink.broken("stands", &violation);
    assert_eq!(on_disk(&folder), NOTES);
}
