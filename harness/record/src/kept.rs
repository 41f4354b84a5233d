//! The record of a run on disk, never more than a second behind, even if the run is killed.

use super::sink::{FileSink, Level, RecordSink};
use super::{Device, Record, Violation};
use std::collections::BTreeSet;
use std::io;
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;
use wire::can::CanFrame;
use wire::time::Timestamp;

/// Interval between flushes to the file: two within the second that the module promises.
const FLUSH_PERIOD: Duration = Duration::from_millis(500);

type Shared = Arc<Mutex<FileSink<'static>>>;

/// A [`FileSink`] that a background thread flushes, also while the run waits for a program, a person or the clock. It
/// is flushed at once when a property breaks. Flushes do not change the content of the file.
pub struct KeptSink {
    sink: Shared,
    level: Level,
    failed: Option<io::Error>,
    /// Properties known to be broken.
    broken: BTreeSet<String>,
    /// Dropped to end the thread.
    stop: Option<Sender<()>>,
    keeper: Option<JoinHandle<()>>,
}

impl KeptSink {
    pub(super) fn new(sink: FileSink<'static>) -> io::Result<Self> {
        let level = sink.level();
        let sink = Arc::new(Mutex::new(sink));
        let (stop, stopped) = mpsc::channel::<()>();
        let kept = Arc::clone(&sink);
        let keeper = thread::Builder::new().name("record".into()).spawn(move || {
            while stopped.recv_timeout(FLUSH_PERIOD) == Err(RecvTimeoutError::Timeout) {
                lock(&kept).flush();
            }
        })?;
        let (stop, keeper) = (Some(stop), Some(keeper));
        Ok(Self { sink, level, failed: None, broken: BTreeSet::new(), stop, keeper })
    }

    /// Passes something to the sink, and keeps the error that stopped it.
    fn with(&mut self, give: impl FnOnce(&mut FileSink<'static>)) {
        let mut sink = lock(&self.sink);
        give(&mut sink);
        if self.failed.is_none() {
            self.failed = sink.take_error();
        }
    }

    fn stop(&mut self) {
        self.stop = None;
        if let Some(keeper) = self.keeper.take() {
            // The thread ends by itself; its panic does not fail the run.
            let _ = keeper.join();
        }
    }
}

/// Locks the sink; it can still be flushed after another thread panicked.
fn lock(sink: &Shared) -> MutexGuard<'_, FileSink<'static>> {
    sink.lock().unwrap_or_else(PoisonError::into_inner)
}

impl RecordSink for KeptSink {
    fn record(&mut self, record: Record) {
        self.with(|sink| sink.record(record));
    }

    fn bytes(&mut self, at: Timestamp, device: Device, bytes: &[u8]) {
        if self.level == Level::Full {
            self.with(|sink| sink.bytes(at, device, bytes));
        }
    }

    fn frame(&mut self, at: Timestamp, device: Device, frame: CanFrame) {
        if self.level == Level::Full {
            self.with(|sink| sink.frame(at, device, frame));
        }
    }

    fn broken(&mut self, name: &str, _: &Violation) {
        if !self.broken.contains(name) {
            self.broken.insert(name.to_owned());
            self.with(FileSink::flush);
        }
    }

    fn level(&self) -> Level {
        self.level
    }

    fn failed(&self) -> Option<&io::Error> {
        self.failed.as_ref()
    }

    fn finish(&mut self) {
        self.stop();
        self.with(RecordSink::finish);
    }
}

impl Drop for KeptSink {
    fn drop(&mut self) {
        self.stop();
    }
}
