//! After a burst of frames and the end of the run, the record has every frame.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use record::header::Header;
use record::reader::RecordError;
use record::run_folder::RunFolder;
use record::sink::{Level, RecordSink};
use record::{Device, Record, RecordKind};
use wire::can::{CanFrame, ExtendedId};
use wire::time::Timestamp;

const BURST: u32 = 200_000;
/// Frame interval of a fully loaded bus at 1 Mbit/s.
const PERIOD_NS: i64 = 111_000;

fn record(number: u32) -> Record {
    let frame = CanFrame::new(ExtendedId::new(number).unwrap(), &number.to_be_bytes()).unwrap();
    let at = Timestamp::from_nanos(i64::from(number) * PERIOD_NS);
    Record { at, device: Device::Base, kind: RecordKind::Frame(frame) }
}

/// A sink on disk that has taken the burst, and its folder.
fn after_the_burst(folder: &tempfile::TempDir) -> (RunFolder, impl RecordSink) {
    let folder = RunFolder::create(folder.path().join("run")).unwrap();
    let mut sink = folder.record_sink(&Header::default(), Level::Full).unwrap();
    (0..BURST).for_each(|number| sink.record(record(number)));
    assert!(sink.failed().is_none(), "{:?}", sink.failed());
    (folder, sink)
}

/// Number of records of the burst that are present and correct, and the error after them.
fn read_back(folder: &RunFolder) -> (u32, Option<RecordError>) {
    let mut count = 0;
    for next in folder.records().unwrap() {
        match next {
            Ok(next) => assert_eq!(next, record(count)),
            Err(error) => return (count, Some(error)),
        }
        count += 1;
    }
    (count, None)
}

#[test]
fn a_burst_and_then_the_end_is_recorded_whole() {
    let temporary = tempfile::tempdir().unwrap();
    let (folder, mut sink) = after_the_burst(&temporary);
    sink.finish();
    assert!(sink.failed().is_none(), "{:?}", sink.failed());
    // Not dropped yet: `finish` alone has written everything out.
    let (count, error) = read_back(&folder);
    assert!(error.is_none(), "{error:?}");
    assert_eq!(count, BURST);
}

#[test]
fn a_burst_that_is_broken_off_lacks_the_end_mark_and_nothing_else() {
    let temporary = tempfile::tempdir().unwrap();
    let (folder, sink) = after_the_burst(&temporary);
    drop(sink);
    let (count, error) = read_back(&folder);
    assert!(matches!(error, Some(RecordError::CutShort { trailing: 0, .. })), "{error:?}");
    assert_eq!(count, BURST);
}
