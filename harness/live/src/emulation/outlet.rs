//! Lines for whoever reads them: a thread waits for readers, and the devices do not.

use std::io::{self, Write};
use std::thread;
use std::time::Duration;
use tokio::sync::mpsc::error::TrySendError;
use tokio::sync::{mpsc, oneshot};
use tokio::time::timeout;

/// Lines that wait to be read, beyond what a pipe holds; further ones are dropped.
pub const LINES_MAX: usize = 1_024;
/// How long the last lines may take to leave.
const FLUSH_MAX: Duration = Duration::from_millis(500);

/// Where lines go.
#[derive(Debug)]
pub(super) struct Outlet {
    lines: mpsc::Sender<String>,
    ended: oneshot::Receiver<io::Result<()>>,
    dropped: u64,
}

impl Outlet {
    /// Starts the thread that writes.
    pub(super) fn spawn(out: impl Write + Send + 'static) -> io::Result<Self> {
        let (lines, waiting) = mpsc::channel(LINES_MAX);
        let (sender, ended) = oneshot::channel();
        thread::Builder::new().name("answers".to_owned()).spawn(move || {
            // Nobody waits for it where the devices ended for another reason.
            let _ = sender.send(write_lines(out, waiting));
        })?;
        Ok(Self { lines, ended, dropped: 0 })
    }

    /// Queues a line; `false` for the first for which there is no room.
    pub(super) fn say(&mut self, line: String) -> bool {
        match self.lines.try_send(line) {
            Err(TrySendError::Full(_)) => {
                self.dropped += 1;
                self.dropped > 1
            }
            // `broken` says why nobody reads any more.
            Ok(()) | Err(TrySendError::Closed(_)) => true,
        }
    }

    /// Lines that nobody made room for.
    pub(super) const fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Waits until nothing can be written any more. May be called off.
    pub(super) async fn broken(&mut self) -> io::Error {
        match (&mut self.ended).await {
            Ok(Err(error)) => error,
            Ok(Ok(())) | Err(_) => io::ErrorKind::BrokenPipe.into(),
        }
    }

    /// Waits until all is written, or nobody reads it.
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
