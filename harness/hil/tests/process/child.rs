//! The process under test, with a deadline for every wait.

use controller::mission::{Report, ReportLine};
use std::io::{BufRead, BufReader, Read as _, Write as _};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Longer than anything here takes.
pub const PATIENCE: Duration = Duration::from_secs(20);
const POLL: Duration = Duration::from_millis(5);

/// A running `k2a-controller`.
pub struct Process {
    child: Child,
    stdin: Option<ChildStdin>,
    reports: Option<Receiver<ReportLine>>,
    log: Option<JoinHandle<String>>,
}

impl Process {
    /// Starts it with these arguments.
    pub fn start(arguments: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_k2a-controller"))
            .args(arguments)
            .env_remove("RUST_LOG")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let (sender, reports) = channel();
        let stdout = BufReader::new(child.stdout.take().unwrap());
        std::thread::spawn(move || {
            // Ends when the receiver is dropped: that closes the process's stdout.
            for line in stdout.lines().map_while(Result::ok) {
                let report = serde_json::from_str(&line).unwrap_or_else(|e| panic!("{e}: {line}"));
                if sender.send(report).is_err() {
                    return;
                }
            }
        });
        let mut stderr = child.stderr.take().unwrap();
        let log = std::thread::spawn(move || {
            let mut text = Vec::new();
            stderr.read_to_end(&mut text).unwrap();
            String::from_utf8_lossy(&text).into_owned()
        });
        let stdin = child.stdin.take();
        Self { child, stdin, reports: Some(reports), log: Some(log) }
    }

    /// Writes to its stdin.
    pub fn say(&mut self, text: impl AsRef<[u8]>) {
        self.stdin.as_mut().unwrap().write_all(text.as_ref()).unwrap();
    }

    /// Closes its stdin.
    pub fn close_stdin(&mut self) {
        self.stdin = None;
    }

    /// Closes its stdout, at the next line that it writes.
    pub fn close_stdout(&mut self) {
        self.reports = None;
    }

    /// Sends it a signal.
    pub fn signal(&self, signal: rustix::process::Signal) {
        let pid = rustix::process::Pid::from_child(&self.child);
        rustix::process::kill_process(pid, signal).unwrap();
    }

    /// Waits for the first report for which `pick` returns a value.
    pub fn wait_for<T>(&mut self, mut pick: impl FnMut(&Report) -> Option<T>) -> T {
        let reports = self.reports.as_ref().unwrap();
        let deadline = now() + PATIENCE;
        loop {
            let left = deadline.saturating_duration_since(now());
            assert!(!left.is_zero(), "others come, and not this report");
            let line = reports.recv_timeout(left).expect("the report comes in time");
            if let Some(found) = pick(&line.report) {
                return found;
            }
        }
    }

    /// Waits for a while.
    pub fn rest(&self, time: Duration) {
        let (_keep, pace) = channel::<()>();
        let _ = pace.recv_timeout(time);
    }

    /// Waits for its end; returns the exit status, the reports not yet seen, and the log.
    pub fn wait(mut self) -> (Option<i32>, Vec<Report>, String) {
        let deadline = now() + PATIENCE;
        let status = loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                break status;
            }
            assert!(now() < deadline, "the process does not end");
            self.rest(POLL);
        };
        let reports = self
            .reports
            .take()
            .map_or_else(Vec::new, |reports| reports.iter().map(|line| line.report).collect());
        (status.code(), reports, self.log.take().unwrap().join().unwrap())
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The clock of all deadlines.
#[expect(clippy::disallowed_methods, reason = "a process runs on the real clock")]
pub fn now() -> Instant {
    Instant::now()
}
