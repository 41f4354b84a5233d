//! Output of lines: a thread waits for readers, so that the devices need not.

use std::io::{self, Write};
use std::thread;
use std::time::Duration;
use tokio::sync::mpsc::error::TrySendError;
use tokio::sync::{mpsc, oneshot};
use tokio::time::timeout;

/// Most lines that wait to be read, beyond the capacity of a pipe; further ones are dropped.
pub const LINES_MAX: usize = 1_024;
/// Time limit for the last lines.
const FLUSH_MAX: Duration = Duration::from_millis(500);

#[derive(Debug)]
pub(super) struct Outlet {
    lines: mpsc::Sender<String>,
    ended: oneshot::Receiver<io::Result<()>>,
    dropped: u64,
}

impl Outlet {
    pub(super) fn spawn(out: impl Write + Send + 'static) -> io::Result<Self> {
        let (lines, waiting) = mpsc::channel(LINES_MAX);
        let (sender, ended) = oneshot::channel();
        thread::Builder::new().name("answers".to_owned()).spawn(move || {
            // There is no receiver if the devices ended for another reason.
            let _ = sender.send(write_lines(out, waiting));
        })?;
        Ok(Self { lines, ended, dropped: 0 })
    }

    /// Queues a line; returns `false` for the first one that finds no room.
    pub(super) fn say(&mut self, line: String) -> bool {
        match self.lines.try_send(line) {
            Err(TrySendError::Full(_)) => {
                self.dropped += 1;
                self.dropped > 1
            }
            // `broken` says why there is no reader any more.
            Ok(()) | Err(TrySendError::Closed(_)) => true,
        }
    }

    /// Number of lines dropped for lack of room.
    pub(super) const fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Waits until writing fails. Cancel-safe.
    pub(super) async fn broken(&mut self) -> io::Error {
        match (&mut self.ended).await {
            Ok(Err(error)) => error,
            Ok(Ok(())) | Err(_) => io::ErrorKind::BrokenPipe.into(),
        }
    }

    /// Waits until all lines are written or the time limit has passed.
    pub(super) async fn finish(self) -> io::Result<()> {
        drop(self.lines);
        match timeout(FLUSH_MAX, self.ended).await {
            Ok(Ok(written)) => written,
            Ok(Err(_)) | Err(_) => Ok(()),
        }
    }
}

fn write_lines(mut out: impl Write, mut lines: mpsc::Receiver<String>) -> io::Result<()> {
    while let Some(line) = lines.blocking_recv() {
        writeln!(out, "{line}")?;
        out.flush()?;
    }
    Ok(())
}
