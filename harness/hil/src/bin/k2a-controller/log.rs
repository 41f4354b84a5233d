//! The log: one line per event on stderr, with the time since start, filtered by `RUST_LOG`.

use crate::outlet::{LineSender, Outlet};
use std::io::{self, IsTerminal as _, Write};
use tracing_subscriber::EnvFilter;
use tracing_subscriber::filter::LevelFilter;
use tracing_subscriber::fmt::MakeWriter;
use tracing_subscriber::fmt::time::uptime;

/// Sends every event of this process to stderr from now on, and never waits for its reader.
///
/// # Errors
/// When the system provides no thread.
pub(crate) fn start() -> io::Result<Outlet> {
    let outlet = Outlet::spawn("log", io::stderr())?;
    let filter =
        EnvFilter::builder().with_default_directive(LevelFilter::INFO.into()).from_env_lossy();
    let subscriber = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_timer(uptime())
        .with_ansi(io::stderr().is_terminal())
        .with_target(false)
        // Internal errors would go to stderr, with a panic if stderr is closed.
        .log_internal_errors(false)
        .with_writer(LogWriter(outlet.sender()));
    if subscriber.try_init().is_err() {
        // Fails only if a log is already set up, which then stays in use.
    }
    Ok(outlet)
}

/// Turns each event into a queued line.
struct LogWriter(LineSender);

impl<'a> MakeWriter<'a> for LogWriter {
    type Writer = &'a Self;

    fn make_writer(&'a self) -> Self::Writer {
        self
    }
}

impl Write for &LogWriter {
    /// The subscriber writes each event in one call.
    fn write(&mut self, event: &[u8]) -> io::Result<usize> {
        self.0.send(event.to_vec());
        Ok(event.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
