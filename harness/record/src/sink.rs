//! Sinks that take the records of a running world.
//!
//! A sink never stops a run, since the base has to be stopped even when the disk is full. After its first error, which
//! it keeps, it takes nothing more; the caller that runs the plan checks [`RecordSink::failed`].

use super::header::Header;
use super::writer::RecordWriter;
use super::{Device, Record, RecordKind, Violation};
use std::io::{self, Write};
use wire::can::CanFrame;
use wire::time::{Span, Timestamp};

/// How much of a run to keep.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Level {
    /// The events of plan, controller and measurements, and the truth once per [`TRUTH_PERIOD`]: enough to judge and
    /// draw the run.
    #[default]
    Events,
    /// Also every byte, every frame and every truth.
    Full,
}

/// Interval of the truth at [`Level::Events`]. Assumption: at 0.4 m/s, half a second draws a point every 0.2 m and adds
/// about 6 MB to 16 hours.
pub const TRUTH_PERIOD: Span = Span::from_millis(500);

/// The most records that a [`MemorySink`] keeps: ten times the events of 16 hours, within 1 GB.
pub const MEMORY_RECORDS_MAX: usize = 4_000_000;

/// Takes events in order.
pub trait RecordSink {
    /// Takes a record, or drops it according to the level.
    fn record(&mut self, record: Record);

    /// Takes bytes of a serial line without allocating a vector.
    fn bytes(&mut self, at: Timestamp, device: Device, bytes: &[u8]) {
        if self.level() == Level::Full {
            self.record(Record { at, device, kind: RecordKind::Bytes(bytes.to_vec()) });
        }
    }

    /// Takes a frame of the bus.
    fn frame(&mut self, at: Timestamp, device: Device, frame: CanFrame) {
        if self.level() == Level::Full {
            self.record(Record { at, device, kind: RecordKind::Frame(frame) });
        }
    }

    /// Notifies the sink that a property does not hold, at every evaluation. The record does not store this: the run is
    /// judged at its end.
    fn broken(&mut self, _name: &str, _violation: &Violation) {}

    /// The level. At [`Level::Events`] the caller need not make records that would be dropped.
    fn level(&self) -> Level;

    /// The error that stopped it.
    fn failed(&self) -> Option<&io::Error>;

    /// Writes everything out and marks the end, after the run. One call is enough.
    fn finish(&mut self);
}

/// Decides which records a level keeps.
#[derive(Debug, Clone, Copy)]
struct Gate {
    level: Level,
    truth_due: Timestamp,
}

impl Gate {
    const fn new(level: Level) -> Self {
        Self { level, truth_due: Timestamp::ZERO }
    }

    fn keeps(&mut self, record: &Record) -> bool {
        if self.level == Level::Full {
            return true;
        }
        match record.kind {
            RecordKind::Bytes(_) | RecordKind::Frame(_) => false,
            RecordKind::Truth { .. } => {
                let due = record.at >= self.truth_due;
                if due {
                    self.truth_due = record.at + TRUTH_PERIOD;
                }
                due
            }
            _ => true,
        }
    }
}

/// Writes a record file. Dropping it writes everything out, but without the end mark.
pub struct FileSink<'a> {
    gate: Gate,
    writer: Option<RecordWriter<'a>>,
    failed: Option<io::Error>,
}

impl<'a> FileSink<'a> {
    /// Writes the header.
    pub fn new(out: impl Write + Send + 'a, header: &Header, level: Level) -> io::Result<Self> {
        let writer = RecordWriter::new(out, header)?;
        Ok(Self { gate: Gate::new(level), writer: Some(writer), failed: None })
    }

    pub(super) fn flush(&mut self) {
        self.attempt(RecordWriter::flush);
    }

    /// Takes the error that stopped it. The sink still accepts nothing more.
    pub(super) fn take_error(&mut self) -> Option<io::Error> {
        self.failed.take().inspect(|_| self.writer = None)
    }

    fn attempt(&mut self, write: impl FnOnce(&mut RecordWriter<'a>) -> io::Result<()>) {
        let Some(writer) = &mut self.writer else {
            return;
        };
        if self.failed.is_none() {
            self.failed = write(writer).err();
        }
    }
}

impl RecordSink for FileSink<'_> {
    fn record(&mut self, record: Record) {
        if self.gate.keeps(&record) {
            self.attempt(|writer| writer.write(&record));
        }
    }

    fn bytes(&mut self, at: Timestamp, device: Device, bytes: &[u8]) {
        if self.gate.level == Level::Full {
            self.attempt(|writer| writer.write_bytes(at, device, bytes));
        }
    }

    fn level(&self) -> Level {
        self.gate.level
    }

    fn failed(&self) -> Option<&io::Error> {
        self.failed.as_ref()
    }

    fn finish(&mut self) {
        self.attempt(RecordWriter::end);
        self.writer = None;
    }
}

/// Keeps records in memory, up to [`MEMORY_RECORDS_MAX`].
#[derive(Debug)]
pub struct MemorySink {
    gate: Gate,
    records: Vec<Record>,
    records_max: usize,
    overflowed: u64,
}

impl MemorySink {
    /// An empty sink.
    pub const fn new(level: Level) -> Self {
        Self::with_records_max(level, MEMORY_RECORDS_MAX)
    }

    /// An empty sink that keeps at most `records_max`.
    pub const fn with_records_max(level: Level, records_max: usize) -> Self {
        Self { gate: Gate::new(level), records: Vec::new(), records_max, overflowed: 0 }
    }

    /// The kept records.
    pub fn records(&self) -> &[Record] {
        &self.records
    }

    /// The kept records, by value.
    pub fn into_records(self) -> Vec<Record> {
        self.records
    }

    /// Number of records that did not fit.
    pub const fn overflowed(&self) -> u64 {
        self.overflowed
    }
}

impl RecordSink for MemorySink {
    fn record(&mut self, record: Record) {
        if !self.gate.keeps(&record) {
        } else if self.records.len() < self.records_max {
            self.records.push(record);
        } else {
            self.overflowed += 1;
        }
    }

    fn level(&self) -> Level {
        self.gate.level
    }

    fn failed(&self) -> Option<&io::Error> {
        None
    }

    fn finish(&mut self) {}
}

/// Keeps nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct NullSink;

impl RecordSink for NullSink {
    fn record(&mut self, _: Record) {}

    fn bytes(&mut self, _: Timestamp, _: Device, _: &[u8]) {}

    fn frame(&mut self, _: Timestamp, _: Device, _: CanFrame) {}

    fn level(&self) -> Level {
        Level::Events
    }

    fn failed(&self) -> Option<&io::Error> {
        None
    }

    fn finish(&mut self) {}
}

/// Passes everything to two sinks: for example a full file, and events in memory to be judged.
#[derive(Debug)]
pub struct Both<A, B>(pub A, pub B);

impl<A: RecordSink, B: RecordSink> RecordSink for Both<A, B> {
    fn record(&mut self, record: Record) {
        self.0.record(record.clone());
        self.1.record(record);
    }

    fn bytes(&mut self, at: Timestamp, device: Device, bytes: &[u8]) {
        self.0.bytes(at, device, bytes);
        self.1.bytes(at, device, bytes);
    }

    fn frame(&mut self, at: Timestamp, device: Device, frame: CanFrame) {
        self.0.frame(at, device, frame);
        self.1.frame(at, device, frame);
    }

    fn broken(&mut self, name: &str, violation: &Violation) {
        self.0.broken(name, violation);
        self.1.broken(name, violation);
    }

    fn level(&self) -> Level {
        match (self.0.level(), self.1.level()) {
            (Level::Events, Level::Events) => Level::Events,
            _ => Level::Full,
        }
    }

    fn failed(&self) -> Option<&io::Error> {
        self.0.failed().or_else(|| self.1.failed())
    }

    fn finish(&mut self) {
        self.0.finish();
        self.1.finish();
    }
}
