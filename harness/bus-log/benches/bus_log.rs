//! Rows of a bus log read and written per second of processor time.
//!
//! `benchmarks/run` runs this and the same with python-can, and compares them;
//! `cargo bench -p bus-log --bench bus_log -- FOLDER` leaves the logs in FOLDER for it. Each figure is the median of
//! [`RUNS`](processor::RUNS) runs, including reading the file.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot go on fails")]

#[path = "../../benches/processor/mod.rs"]
mod processor;

use bus_log::{Channel, Direction, Entry, Format, LogReader, LogWriter, Payload};
use embedded_can::Frame as _;
use processor::{median, processor_s};
use std::hint::black_box;
use std::path::{Path, PathBuf};
use wire::can::{CanFrame, ExtendedId, FdFlags, StandardId};
use wire::time::Timestamp;

/// Rows of a log: 20 s of processor time for the slowest reader in the comparison.
const ROWS: u64 = 1_000_000;
/// Time between two rows: a bus of 500 kbit/s at half load.
const PERIOD_NS: i64 = 450_000;
/// Time of the first row, in 2015.
const BEGAN_NS: i64 = 1_436_509_052_249_713_000;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    // `cargo test --benches` only checks that it starts.
    if arguments.iter().any(|argument| argument == "--test") {
        return;
    }
    let given = arguments.iter().find(|argument| !argument.starts_with("--"));
    let temporary = tempfile::tempdir().unwrap();
    let folder = given.map_or_else(|| temporary.path().to_owned(), PathBuf::from);
    for format in Format::ALL {
        let path = folder.join(format!("rows.{}", format.extension()));
        report("hil", format, "write", median(|| write(&path, format)));
        report("hil", format, "read", median(|| read(&path, format)));
    }
}

fn report(who: &str, format: Format, what: &str, rows_per_s: f64) {
    println!(
        "{who:<12} {:<8} {what:<6} {rows_per_s:>12.0} rows/s of processor time",
        format.name()
    );
}

/// Typical traffic of a machine: mostly eight data bytes with standard identifiers.
fn entry(row: u64) -> Entry {
    let data = row.wrapping_mul(0x9e37_79b9_7f4a_7c15).to_be_bytes();
    let standard = StandardId::new((row % 0x800) as u16).unwrap();
    let extended = ExtendedId::new((row % 0x1fff_ffff) as u32).unwrap();
    let payload = match row % 16 {
        0 => Payload::Frame(CanFrame::new_remote(standard, 4).unwrap()),
        1 => {
            Payload::Frame(CanFrame::fd(standard, FdFlags::default(), &[data; 2].concat()).unwrap())
        }
        2..5 => Payload::Frame(CanFrame::new(extended, &data).unwrap()),
        _ => Payload::Frame(CanFrame::new(standard, &data).unwrap()),
    };
    Entry {
        at: Timestamp::from_nanos(BEGAN_NS + row as i64 * PERIOD_NS),
        channel: Channel::numbered((row % 2) as u32),
        direction: Some(if row.is_multiple_of(3) { Direction::Tx } else { Direction::Rx }),
        payload,
    }
}

fn write(path: &Path, format: Format) -> f64 {
    let began = processor_s();
    let mut writer = LogWriter::create(path, format).unwrap();
    for row in 0..ROWS {
        let _ = writer.write(&entry(row)).unwrap();
    }
    writer.finish().unwrap();
    ROWS as f64 / (processor_s() - began)
}

fn read(path: &Path, format: Format) -> f64 {
    let began = processor_s();
    let mut rows = 0;
    for entry in LogReader::open(path, format).unwrap() {
        black_box(entry.unwrap());
        rows += 1;
    }
    assert_eq!(rows, ROWS);
    rows as f64 / (processor_s() - began)
}
