//! Tests of the file: writer and reader together.

mod damage;

use super::encoding::{PREFIX_BYTES_MAX, RECORD_BYTES_MAX};
use super::header::{
    FORMAT_VERSION, HEADER_BYTES_MAX, Header, MAGIC, OLDEST_FORMAT_VERSION, Quantity,
};
use super::reader::{RecordError, RecordReader};
use super::samples::{any_record, one_of_each, record, state};
use super::sink::{Both, FileSink, Level, MemorySink, RecordSink, TRUTH_PERIOD};
use super::writer::RecordWriter;
use super::{Device, Record, RecordKind};
use controller::calibration::Calibration;
use controller::mission::{Command, Report};
use proptest::prelude::*;
use std::io::{self, Cursor, Write};
use wire::time::Timestamp;

/// Bytes after the last record: a mark with its checksum, and the trailer.
const END_BYTES: usize = 2 + 4 + 8;

fn header() -> Header {
    Header { harness: "0.1.0".into(), plan: "laps".into(), seed: 7, ..Header::default() }
}

fn written(records: &[Record]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut writer = RecordWriter::new(&mut file, &header()).unwrap();
    records.iter().for_each(|record| writer.write(record).unwrap());
    writer.finish().unwrap();
    file
}

fn reader(file: &[u8]) -> Result<RecordReader, RecordError> {
    RecordReader::new(Cursor::new(file.to_vec()))
}

fn read(file: &[u8]) -> (Vec<Record>, Option<RecordError>) {
    let mut records = Vec::new();
    for record in reader(file).unwrap() {
        match record {
            Ok(record) => records.push(record),
            Err(error) => return (records, Some(error)),
        }
    }
    (records, None)
}

fn refusal(file: &[u8]) -> RecordError {
    reader(file).expect_err("refused")
}

#[test]
fn the_header_says_whose_record_it_is() {
    let file = written(&[]);
    let text = String::from_utf8_lossy(&file);
    assert!(text.contains(r#"{"harness":"0.1.0","plan":"laps","seed":7,"quantities":[]}"#));
    assert_eq!(reader(&file).unwrap().header(), &header());
}

#[test]
fn foreign_older_and_newer_files_are_refused_by_name() {
    let mut newer = written(&[]);
    newer[MAGIC.len()] = FORMAT_VERSION as u8 + 1;
    assert!(matches!(refusal(&newer), RecordError::NewerFormat { found: 4 }));
    let mut older = written(&[]);
    older[MAGIC.len()] = OLDEST_FORMAT_VERSION as u8 - 1;
    assert!(matches!(refusal(&older), RecordError::OlderFormat { found: 1 }));
    assert!(matches!(refusal(b"candump log, certainly"), RecordError::NotARecord));
    assert!(matches!(refusal(b""), RecordError::NotARecord));
    assert!(matches!(refusal(&written(&[])[..20]), RecordError::HeaderCutShort));
    let mut long = written(&[]);
    long[10..14].copy_from_slice(&(HEADER_BYTES_MAX as u32 + 1).to_le_bytes());
    assert!(matches!(refusal(&long), RecordError::HeaderTooLong { .. }));
}

#[test]
fn a_header_too_long_to_be_read_is_not_written() {
    let title = "x".repeat(HEADER_BYTES_MAX);
    let quantities = vec![Quantity { title, ..Quantity::default() }];
    assert!(RecordWriter::new(Vec::new(), &Header { quantities, ..header() }).is_err());
}

#[test]
fn a_sample_takes_at_most_twenty_bytes() {
    let sample = |index: i64| Record {
        at: Timestamp::from_nanos(57_000_000_000_000 + 10_000_000 * index),
        device: Device::Gyro,
        kind: RecordKind::Bytes(vec![0x80; 8]),
    };
    let few = written(&(0..100).map(sample).collect::<Vec<_>>()).len();
    let more = written(&(0..200).map(sample).collect::<Vec<_>>()).len();
    assert_eq!((more - few) / 100, 16, "a block of a thousand shares a check");
}

#[test]
fn a_record_beyond_the_bound_becomes_a_note() {
    let long = RecordKind::Bytes(vec![0; RECORD_BYTES_MAX]);
    let (records, error) = read(&written(&[record(1.0, Device::Gyro, long)]));
    assert!(error.is_none());
    let RecordKind::Note(text) = &records[0].kind else { panic!("{records:?}") };
    assert!(text.contains("left out"), "{text}");
}

#[test]
fn damage_is_named_with_its_place() {
    let mut file = written(&[]);
    file.truncate(file.len() - END_BYTES);
    let offset = file.len() as u64;
    file.extend([2, 0xff, 0xff, 0]);
    let (records, error) = read(&file);
    assert!(records.is_empty());
    assert!(matches!(error, Some(RecordError::Damaged { offset: o, .. }) if o == offset));

    let mut longer = written(&one_of_each());
    longer.push(0);
    assert!(matches!(read(&longer).1, Some(RecordError::Damaged { .. })));
}

#[test]
fn a_record_in_memory_is_small() {
    assert!(size_of::<Record>() <= 256, "{}", size_of::<Record>());
}

/// A disk with room for this many bytes.
struct SmallDisk(usize);

impl Write for SmallDisk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.0 < bytes.len() {
            return Err(io::Error::from(io::ErrorKind::StorageFull));
        }
        self.0 -= bytes.len();
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_full_disk_is_remembered_and_does_not_stop_the_run() {
    let mut sink = FileSink::new(SmallDisk(1_000_000), &header(), Level::Full).unwrap();
    for index in 0..200_000 {
        sink.bytes(Timestamp::from_nanos(index), Device::Gyro, &[0; 8]);
    }
    assert_eq!(sink.failed().map(io::Error::kind), Some(io::ErrorKind::StorageFull));
    sink.finish();
    assert_eq!(sink.failed().map(io::Error::kind), Some(io::ErrorKind::StorageFull));
}

#[test]
fn events_leave_out_what_comes_at_full_rate() {
    let mut sink = MemorySink::new(Level::Events);
    let truth = one_of_each()[12].kind.clone();
    let period_s = TRUTH_PERIOD.as_secs_f64();
    for step in 0..40 {
        sink.record(record(f64::from(step) * period_s / 10.0, Device::Base, truth.clone()));
    }
    assert_eq!(sink.records().len(), 4);
    sink.bytes(Timestamp::ZERO, Device::Gyro, &[1]);
    for each in one_of_each() {
        sink.record(each);
    }
    assert_eq!(sink.records().len(), 4 + one_of_each().len() - 2);
}

#[test]
fn memory_is_bounded_and_counts_what_is_lost() {
    let mut sink = MemorySink::with_records_max(Level::Full, 3);
    one_of_each().into_iter().for_each(|each| sink.record(each));
    assert_eq!(sink.records().len(), 3);
    assert_eq!(sink.overflowed(), one_of_each().len() as u64 - 3);
}

#[test]
fn a_dropped_sink_has_written_everything_but_the_end_mark() {
    let mut file = Vec::new();
    let mut sink = Both(
        FileSink::new(&mut file, &header(), Level::Full).unwrap(),
        MemorySink::new(Level::Events),
    );
    one_of_each().into_iter().for_each(|each| sink.record(each));
    drop(sink);
    let (records, error) = read(&file);
    assert_eq!(records, one_of_each());
    assert!(matches!(error, Some(RecordError::CutShort { trailing: 0, .. })));
    let told = error.unwrap().to_string();
    assert!(told.ends_with(" without its end mark") && !told.contains("0 bytes"), "{told}");
}

/// Text may leave out what is not given; a record is read by position and may not.
#[test]
fn a_model_that_a_controller_is_given_comes_back() {
    let drivers = [
        r#""temperature""#,
        r#"{ "temperature_lag": { "time_constant_s": 90.0 } }"#,
        r#""rate""#,
        r#""time""#,
    ];
    let forms = [
        r#"{ "linear": { "slope": 1e-5, "origin": 20.0 } }"#,
        r#"{ "table": { "points": [{ "x": 1.0, "value": 2.0 }, { "x": 2.0, "value": 3.0 }] } }"#,
        r#"{ "product": { "coefficient": 1.0, "origin": 0.0, "second": "uptime", "origin_2": 1.0 } }"#,
    ];
    let ranges = ["", r#", "within": [-1.0, 1.0]"#, r#", "within_2": [0.0, 1.0]"#];
    let terms = drivers.iter().flat_map(|driver| {
        let forms = forms.iter().zip(ranges);
        forms.map(move |(form, range)| {
            format!(r#"{{ "acts": "bias", "driver": {driver}, "form": {form}{range} }}"#)
        })
    });
    let terms = Vec::from_iter(terms).join(", ");
    let calibration =
        format!(r#"{{ "factors": [{{ "constant": 1.1 }}], "corrections": [{terms}] }}"#);
    let calibration: Calibration = serde_json::from_str(&calibration).unwrap();
    assert_eq!(calibration.corrections.len(), 12);
    let command = RecordKind::Command(Box::new(Command::SetCalibration(calibration)));
    let records = [record(1.0, Device::Plan, command)];
    let (back, error) = read(&written(&records));
    assert!(error.is_none(), "{error:?}");
    assert_eq!(back, records);
}

proptest! {
    #[test]
    fn records_come_back(records in prop::collection::vec(any_record(), 0..20)) {
        let (back, error) = read(&written(&records));
        prop_assert!(error.is_none());
        prop_assert_eq!(back, records);
    }

    #[test]
    fn a_slice_gives_the_bytes_of_the_owned_record(
        samples in prop::collection::vec((any::<i64>(), prop::collection::vec(any::<u8>(), 0..200)), 0..10),
    ) {
        let mut owned = MemorySink::new(Level::Full);
        let mut file = Vec::new();
        let mut sink = FileSink::new(&mut file, &header(), Level::Full).unwrap();
        for (at, bytes) in &samples {
            let at = Timestamp::from_nanos(*at);
            sink.bytes(at, Device::Gyro, bytes);
            owned.bytes(at, Device::Gyro, bytes);
        }
        sink.finish();
        drop(sink);
        prop_assert_eq!(file, written(owned.records()));
    }

    #[test]
    fn a_file_cut_anywhere_reads_up_to_the_last_whole_record(
        records in prop::collection::vec(any_record(), 1..8),
        cut in any::<prop::sample::Index>(),
    ) {
        let whole = written(&records);
        let start = written(&[]).len() - END_BYTES;
        let length = start + cut.index(whole.len() - start);
        let (back, error) = read(&whole[..length]);
        prop_assert_eq!(&back[..], &records[..back.len()]);
        match error {
            Some(RecordError::CutShort { offset, trailing }) => {
                prop_assert_eq!(offset + trailing, length as u64);
                prop_assert_eq!(offset as usize, written(&back).len() - END_BYTES);
            }
            other => prop_assert!(false, "{other:?}"),
        }
    }

    #[test]
    fn no_bytes_panic(
        noise in prop::collection::vec(any::<u8>(), 0..300),
        at in any::<prop::sample::Index>(),
        flipped in any::<u8>(),
    ) {
        let _ = reader(&noise).map(Iterator::count);
        let mut behind_header = written(&[]);
        behind_header.truncate(behind_header.len() - END_BYTES);
        behind_header.extend(&noise);
        let found = reader(&behind_header).unwrap().count();
        prop_assert!(found <= noise.len() + 1);
        let mut file = written(&one_of_each());
        let index = at.index(file.len());
        file[index] ^= flipped;
        let _ = reader(&file).map(Iterator::count);
    }
}

#[test]
fn the_longest_record_fits_its_prefix() {
    const { assert!(RECORD_BYTES_MAX < 1 << (7 * PREFIX_BYTES_MAX)) };
    let fits = RecordKind::Bytes(vec![7; RECORD_BYTES_MAX - 20]);
    let records = [
        record(1.0, Device::Gyro, fits),
        record(2.0, Device::Controller, RecordKind::Report(Report::State(state(0.0, 0.0)))),
    ];
    assert_eq!(read(&written(&records)).0, records);
}

/// The bound of the 16-hour run; in a debug build the test proves nothing.
#[test]
#[cfg_attr(debug_assertions, ignore = "a bound for release builds")]
fn six_million_samples_are_written_in_two_seconds() {
    #[expect(clippy::disallowed_methods, reason = "this test is about real time")]
    let begin = std::time::Instant::now();
    let mut sink = FileSink::new(io::sink(), &header(), Level::Full).unwrap();
    for index in 0..6_000_000 {
        let at = Timestamp::from_nanos(index * 10_000_000);
        sink.bytes(at, Device::Gyro, &[0x80, 1, 2, 3, 4, 5, 6, 7]);
    }
    sink.finish();
    let seconds = begin.elapsed().as_secs_f64();
    assert!(seconds < 2.0, "{seconds} s");
}
