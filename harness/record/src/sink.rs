//! Where a running world puts its records.
//!
//! A sink never stops a run: the base has to be brought to rest even when the disk is full. It keeps
//! its first error and takes nothing more; whoever runs the plan asks [`RecordSink::failed`].

use super::header::Header;
use super::writer::RecordWriter;
use super::{Device, Record, RecordKind, Violation};
use std::io::{self, Write};
use wire::can::CanFrame;
use wire::time::{Span, Timestamp};

/// How much of a run is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Level {
    /// What the plan, the controller and the measurements said, and the truth once in
    /// [`TRUTH_PERIOD`]: enough to judge and to draw.
    #[default]
    Events,
    /// Also every byte, every frame and the truth as often as it is told.
    Full,
}

/// How often the truth is kept at [`Level::Events`]. Assumption: half a second draws a path of
/// 0.4 m/s with a point each 0.2 m and adds some 6 MB to 16 hours.
pub const TRUTH_PERIOD: Span = Span::from_millis(500);

/// The most records that a [`MemorySink`] keeps: ten times the events of 16 hours, within 1 GB.
pub const MEMORY_RECORDS_MAX: usize = 4_000_000;

/// Takes what happens, in order.
pub trait RecordSink {
    /// Takes a record, or leaves it out by its level.
    fn record(&mut self, record: Record);

    /// Takes bytes of a serial line without a vector for them.
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

    /// Hears that a property does not hold, as often as somebody looks. The record has no place for it: a run is
    /// judged by it at its end.
    fn broken(&mut self, _name: &str, _violation: &Violation) {}

    /// What it keeps. Who finds [`Level::Events`] need not make what would be left out.
    fn level(&self) -> Level;

    /// The error that stopped it.
    fn failed(&self) -> Option<&io::Error>;

    /// The run is over: everything is written out and the end is marked. Once is enough.
    fn finish(&mut self);
}

/// Decides what a level keeps.
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

/// Writes a record file. What was written arrives when it is dropped, too, but without its end mark.
#[derive(Debug)]
pub struct FileSink<W: Write> {
    gate: Gate,
    writer: Option<RecordWriter<W>>,
    failed: Option<io::Error>,
}

impl<W: Write> FileSink<W> {
    /// Writes the header.
    pub fn new(out: W, header: &Header, level: Level) -> io::Result<Self> {
        let writer = RecordWriter::new(out, header)?;
        Ok(Self { gate: Gate::new(level), writer: Some(writer), failed: None })
    }

    /// Gives everything to the file.
    pub(super) fn flush(&mut self) {
        self.attempt(RecordWriter::flush);
    }

    /// The error that stopped it, by value. It takes nothing more all the same.
    pub(super) fn take_error(&mut self) -> Option<io::Error> {
        self.failed.take().inspect(|_| self.writer = None)
    }

    fn attempt(&mut self, write: impl FnOnce(&mut RecordWriter<W>) -> io::Result<()>) {
        let Some(writer) = &mut self.writer else {
            return;
        };
        if self.failed.is_none() {
            self.failed = write(writer).err();
        }
    }
}

impl<W: Write> RecordSink for FileSink<W> {
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
    /// Nothing yet.
    pub const fn new(level: Level) -> Self {
        Self::with_records_max(level, MEMORY_RECORDS_MAX)
    }

    /// Nothing yet, and never more than `records_max`.
    pub const fn with_records_max(level: Level, records_max: usize) -> Self {
        Self { gate: Gate::new(level), records: Vec::new(), records_max, overflowed: 0 }
    }

    /// What was kept.
    pub fn records(&self) -> &[Record] {
        &self.records
    }

    /// What was kept, by value.
    pub fn into_records(self) -> Vec<Record> {
        self.records
    }

    /// How many there was no room for.
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

impl<S: RecordSink + ?Sized> RecordSink for Box<S> {
    fn record(&mut self, record: Record) {
        (**self).record(record);
    }

    fn bytes(&mut self, at: Timestamp, device: Device, bytes: &[u8]) {
        (**self).bytes(at, device, bytes);
    }

    fn frame(&mut self, at: Timestamp, device: Device, frame: CanFrame) {
        (**self).frame(at, device, frame);
    }

    fn broken(&mut self, name: &str, violation: &Violation) {
        (**self).broken(name, violation);
    }

    fn level(&self) -> Level {
        (**self).level()
    }

    fn failed(&self) -> Option<&io::Error> {
        (**self).failed()
    }

    fn finish(&mut self) {
        (**self).finish();
    }
}

/// Two sinks that take the same: a full file, say, and the events in memory to be judged.
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
