//! The three pipes of a process, each with a thread that may block so that the harness does not.

use super::{ProcessEvent, Unread};
use controller::mission::{Mission, ReportLine};
use std::fs::File;
use std::io::{self, BufRead, BufReader, PipeReader, PipeWriter, Read as _, Write as _};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;
use tokio::sync::{mpsc, oneshot};

/// Longest line on stdin and stdout. A `set_calibration` with every factor, the whole bias table and a full table in every
/// correction fits, each number with all its digits; the longest report of our controller is a state of about 700 bytes.
pub const LINE_BYTES_MAX: usize = 64 * 1_024;
/// Most bytes of stderr that are kept; the rest is discarded.
pub const LOG_BYTES_MAX: usize = 16 * 1_024 * 1_024;
/// Most events that wait to be fetched; beyond that the pipe fills, and then the process waits.
pub(super) const EVENTS_MAX: usize = 1_024;
pub(super) const MISSIONS_MAX: usize = 64;
/// Bytes of stderr kept for quotation.
const TAIL_BYTES_MAX: usize = 1_024;
const TAIL_LINES_MAX: usize = 6;
/// Bytes per read of stderr.
const READ_BYTES: usize = 4_096;

/// The sender to a process's stdin. Dropping it closes the pipe once all is written.
#[derive(Debug)]
pub(super) struct MissionSender(SyncSender<Vec<u8>>);

impl MissionSender {
    pub(super) fn spawn(pipe: PipeWriter) -> io::Result<Self> {
        let (sender, lines) = sync_channel(MISSIONS_MAX);
        thread::Builder::new()
            .name("missions".to_owned())
            .spawn(move || write_lines(pipe, &lines))?;
        Ok(Self(sender))
    }

    /// Queues a mission; `false` if there is no room or no reader.
    pub(super) fn send(&self, mission: &Mission) -> bool {
        line_of(mission).is_some_and(|line| self.0.try_send(line).is_ok())
    }
}

pub fn line_of(mission: &Mission) -> Option<Vec<u8>> {
    let mut line = serde_json::to_vec(mission).ok()?;
    line.push(b'\n');
    Some(line)
}

fn write_lines(mut pipe: PipeWriter, lines: &Receiver<Vec<u8>>) {
    for line in lines {
        if pipe.write_all(&line).is_err() {
            // The process has closed its stdin; dropping the receiver notifies the sender.
            return;
        }
    }
}

/// Starts the thread that reads a process's stdout.
pub(super) fn spawn_report_reader(
    pipe: PipeReader,
    events: mpsc::Sender<ProcessEvent>,
) -> io::Result<()> {
    thread::Builder::new()
        .name("reports".to_owned())
        .spawn(move || read_reports(BufReader::new(pipe), &events))
        .map(drop)
}

fn read_reports(mut pipe: impl BufRead, events: &mpsc::Sender<ProcessEvent>) {
    let mut line = Vec::new();
    for number in 1.. {
        let Ok(Some(end)) = next_line(&mut pipe, &mut line) else { return };
        let whole = (end == LineEnd::Whole).then_some(line.as_slice());
        let Some(line) = ReportedLine::read(number, whole) else { continue };
        if events.blocking_send(ProcessEvent::Line(line)).is_err() {
            return;
        }
    }
}

/// A line that should be a report.
#[derive(Debug, Clone, PartialEq)]
pub enum ReportedLine {
    /// A report, with the time by the device's own clock.
    Report(Box<ReportLine>),
    Bad {
        /// Line number, from one.
        number: u64,
        unread: Unread,
    },
}

impl ReportedLine {
    /// Reads the line of this number; `None` for a blank one. `line` is `None` for an overlong line.
    pub fn read(number: u64, line: Option<&[u8]>) -> Option<Self> {
        let read = report_of(line)?;
        Some(read.map_or_else(|unread| Self::Bad { number, unread }, Self::Report))
    }
}

/// The report in a line, or the mistake in it; `line` is `None` for an overlong line. Returns `None` for a blank line.
pub fn report_of(line: Option<&[u8]>) -> Option<Result<Box<ReportLine>, Unread>> {
    let Some(line) = line else {
        let cause = format!("longer than {LINE_BYTES_MAX} bytes");
        return Some(Err(Unread { cause, is_grave: false }));
    };
    let line = line.trim_ascii();
    if line.is_empty() {
        return None;
    }
    let read = serde_json::from_slice(line);
    Some(read.map(Box::new).map_err(|cause| Unread::new(line, &cause.to_string())))
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineEnd {
    /// With a line feed, or with the pipe.
    Whole,
    /// Longer than [`LINE_BYTES_MAX`]; the rest has been skipped.
    Overlong,
}

/// Reads the next line, which the end of the pipe also ends; `None` if there are no more.
///
/// # Errors
/// When the pipe cannot be read.
pub fn next_line(pipe: &mut impl BufRead, line: &mut Vec<u8>) -> io::Result<Option<LineEnd>> {
    line.clear();
    let limit = LINE_BYTES_MAX as u64 + 1;
    if pipe.by_ref().take(limit).read_until(b'\n', line)? == 0 {
        return Ok(None);
    }
    if line.len() <= LINE_BYTES_MAX || line.ends_with(b"\n") {
        return Ok(Some(LineEnd::Whole));
    }
    pipe.skip_until(b'\n')?;
    Ok(Some(LineEnd::Overlong))
}

/// Copies a process's stderr into a file.
#[derive(Debug)]
pub(super) struct Log {
    tail: Arc<Mutex<Vec<u8>>>,
    /// Signals the end of stderr, until it has been seen.
    ended: Option<oneshot::Receiver<()>>,
}

impl Log {
    /// Starts the thread that copies into `file`, as many bytes as it is to take.
    pub(super) fn spawn(pipe: PipeReader, (file, room): (File, usize)) -> io::Result<Self> {
        let tail = Arc::<Mutex<Vec<u8>>>::default();
        let (ended_sender, ended) = oneshot::channel();
        let kept = Arc::clone(&tail);
        thread::Builder::new().name("stderr".to_owned()).spawn(move || {
            copy(pipe, (file, room), &kept);
            // There is no receiver if the process is dropped instead of ended.
            let _ = ended_sender.send(());
        })?;
        Ok(Self { tail, ended: Some(ended) })
    }

    /// Waits until all is in the file, or `limit` has passed.
    pub(super) async fn finish(&mut self, limit: Duration) {
        if let Some(ended) = &mut self.ended
            && tokio::time::timeout(limit, ended).await.is_ok()
        {
            self.ended = None;
        }
    }

    /// See [`super::DeviceProcess::last_words`].
    pub(super) fn last_words(&self) -> String {
        let tail = self.tail.lock().unwrap_or_else(PoisonError::into_inner);
        let text = String::from_utf8_lossy(&tail);
        last_lines(&text, TAIL_LINES_MAX)
            .join("\n")
            .replace(|c: char| c.is_control() && c != '\n', "?")
    }
}

/// The last lines of a text that are not blank.
pub(crate) fn last_lines(text: &str, most: usize) -> Vec<&str> {
    let lines: Vec<&str> = text.lines().filter(|line| !line.trim().is_empty()).collect();
    lines.get(lines.len().saturating_sub(most)..).unwrap_or_default().to_vec()
}

fn copy(mut pipe: PipeReader, (mut file, mut room): (File, usize), tail: &Mutex<Vec<u8>>) {
    let mut buffer = [0; READ_BYTES];
    loop {
        let bytes = match pipe.read(&mut buffer) {
            Ok(0) => return,
            Ok(count) => buffer.get(..count).unwrap_or_default(),
            Err(cause) if cause.kind() == io::ErrorKind::Interrupted => continue,
            Err(_) => return,
        };
        {
            let mut tail = tail.lock().unwrap_or_else(PoisonError::into_inner);
            tail.extend_from_slice(bytes);
            let excess = tail.len().saturating_sub(TAIL_BYTES_MAX);
            tail.drain(..excess);
        }
        // A full disk shows up where the record is written; the process must be drained all the same.
        let _ = file.write_all(bytes.get(..room).unwrap_or(bytes));
        if room > 0 && room < bytes.len() {
            let _ = file.write_all(b"\n[the rest was not kept]\n");
        }
        room = room.saturating_sub(bytes.len());
    }
}

#[cfg(test)]
mod tests {
    use super::{LINE_BYTES_MAX, ProcessEvent, ReportedLine, Unread, read_reports};
    use std::io::BufReader;
    use tokio::sync::mpsc;

    fn events(bytes: &[u8]) -> Vec<ProcessEvent> {
        let (sender, mut receiver) = mpsc::channel(100);
        read_reports(BufReader::with_capacity(7, bytes), &sender);
        drop(sender);
        std::iter::from_fn(|| receiver.blocking_recv()).collect()
    }

    #[test]
    fn reports_are_told_from_everything_else() {
        let long = vec![b'x'; 3 * LINE_BYTES_MAX];
        let report = br#"{"at_ns":5,"report":{"refused":{"id":1,"reason":"busy"}}}"#;
        let bytes = [report, &b"\r\n\n"[..], b"\x1b[0mhello\n", &long, b"\n", report].concat();
        let events = events(&bytes);
        assert_eq!(events.len(), 4);
        assert!(
            matches!(&events[0], ProcessEvent::Line(ReportedLine::Report(line)) if line.at.as_nanos() == 5)
        );
        let bad = |event: &ProcessEvent| match event {
            ProcessEvent::Line(ReportedLine::Bad { number, unread }) => (*number, unread.clone()),
            event => panic!("{event:?}"),
        };
        let (3, Unread { cause, is_grave: false }) = bad(&events[1]) else { panic!("{events:?}") };
        assert!(cause.ends_with("\\u{1b}[0mhello"), "{cause}");
        let (4, Unread { cause, is_grave: false }) = bad(&events[2]) else { panic!("{events:?}") };
        assert!(cause.contains("longer"), "{cause}");
        assert_eq!(events[3], events[0]);
    }
}
