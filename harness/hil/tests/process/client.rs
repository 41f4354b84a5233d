//! A client of a controller that listens on a socket.

use crate::child::{PATIENCE, now};
use controller::mission::{Report, ReportLine};
use std::io::{BufRead as _, BufReader, Write as _};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::sync::mpsc::channel;
use std::time::Duration;

/// Interval between two attempts to connect.
const POLL: Duration = Duration::from_millis(5);

/// A connection, with a deadline for every wait.
pub struct Client {
    stream: UnixStream,
    reports: BufReader<UnixStream>,
}

impl Client {
    /// Connects once the controller listens.
    pub fn connect(socket: &Path) -> Self {
        let deadline = now() + PATIENCE;
        let (_keep, pace) = channel::<()>();
        loop {
            match UnixStream::connect(socket) {
                Ok(stream) => {
                    stream.set_read_timeout(Some(PATIENCE)).unwrap();
                    let reports = BufReader::new(stream.try_clone().unwrap());
                    return Self { stream, reports };
                }
                Err(error) => assert!(now() < deadline, "{error}"),
            }
            let _ = pace.recv_timeout(POLL);
        }
    }

    /// Writes to it.
    pub fn say(&mut self, text: &str) {
        self.stream.write_all(text.as_bytes()).unwrap();
    }

    /// Waits for the first report for which `pick` returns a value.
    pub fn wait_for<T>(&mut self, mut pick: impl FnMut(&Report) -> Option<T>) -> T {
        let deadline = now() + PATIENCE;
        loop {
            assert!(now() < deadline, "others come, and not this report");
            let mut line = String::new();
            self.reports.read_line(&mut line).unwrap();
            let told: ReportLine =
                serde_json::from_str(&line).unwrap_or_else(|e| panic!("{e}: {line:?}"));
            if let Some(found) = pick(&told.report) {
                return found;
            }
        }
    }
}
