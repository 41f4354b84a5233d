//! Signals by which the system asks the process to end.

use std::io;
use tokio::signal::unix::{Signal, SignalKind, signal};

/// Waits for the first signal that asks for an orderly end, and returns its name.
pub(crate) struct Signals([(&'static str, Signal); 3]);

impl Signals {
    /// From now on the signals no longer kill the process. Must be called within the runtime.
    ///
    /// # Errors
    /// When the system refuses the handlers.
    pub(crate) fn install() -> io::Result<Self> {
        Ok(Self([
            ("SIGTERM", signal(SignalKind::terminate())?),
            ("SIGINT", signal(SignalKind::interrupt())?),
            ("SIGHUP", signal(SignalKind::hangup())?),
        ]))
    }

    pub(crate) async fn next(&mut self) -> &'static str {
        let [(first, one), (second, two), (third, three)] = &mut self.0;
        tokio::select! {
            _ = one.recv() => first,
            _ = two.recv() => second,
            _ = three.recv() => third,
        }
    }
}
