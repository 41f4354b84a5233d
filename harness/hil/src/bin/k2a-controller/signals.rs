//! Signals by which the system asks the process to end.

use std::io;

/// Waits for the first signal that asks for an orderly end, and returns its name.
#[cfg(unix)]
pub(crate) struct Signals([(&'static str, tokio::signal::unix::Signal); 3]);

#[cfg(unix)]
impl Signals {
    /// From now on the signals no longer kill the process. Must be called within the runtime.
    ///
    /// # Errors
    /// When the system refuses the handlers.
    pub(crate) fn install() -> io::Result<Self> {
        use tokio::signal::unix::{SignalKind, signal};
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

/// Waits for Ctrl-C.
#[cfg(not(unix))]
pub(crate) struct Signals;

#[cfg(not(unix))]
impl Signals {
    /// Does nothing until the first wait.
    ///
    /// # Errors
    /// Never.
    pub(crate) fn install() -> io::Result<Self> {
        Ok(Self)
    }

    /// Waits for the next Ctrl-C.
    pub(crate) async fn next(&mut self) -> &'static str {
        if tokio::signal::ctrl_c().await.is_err() {
            std::future::pending::<()>().await;
        }
        "Ctrl-C"
    }
}
