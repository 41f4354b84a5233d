//! A device under test that is a process of its own: missions go to its stdin and reports come from its
//! stdout, one JSON line each ([`controller::mission`]); its stderr is kept in a file.
//!
//! Nothing here waits for the process: missions that it does not take are counted, reports that are not
//! fetched wait in the pipe. It is the leader of a process group, so that a wrapper such as `sh` or
//! `cargo run` ends together with what it started, and so that a Ctrl-C in the harness's terminal
//! reaches the harness alone, which then ends it in order.

mod pipes;
#[cfg(test)]
mod tests;

pub use pipes::{LINE_BYTES_MAX, LOG_BYTES_MAX};
pub use pipes::{line_of, report_of};

use super::lines::{self, Places};
use controller::mission::{Mission, ReportLine};
use pipes::{Log, MissionSender};
use rustix::process::{Pid, Signal, kill_process_group};
use std::fmt;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitStatus;
use std::process::Stdio;
use std::time::Duration;
use tokio::process::{Child, Command};
use tokio::sync::mpsc;
use tokio::time::timeout;

/// How long it may take to end after its stdin is closed. Assumption: the two seconds in which our
/// controller brings the base to rest, one to write what is left, and as much again.
pub const CLOSE_WAIT: Duration = Duration::from_secs(6);
/// How long it may take to end after SIGTERM. Assumption: as above, without the reserve.
pub const TERMINATE_WAIT: Duration = Duration::from_secs(3);
/// How long the system may take to end it after SIGKILL.
pub const KILL_WAIT: Duration = Duration::from_secs(5);
/// How long what it wrote before it ended may take to arrive.
const REST_WAIT: Duration = Duration::from_millis(500);

/// What came from the process.
#[derive(Debug, Clone, PartialEq)]
pub enum ProcessEvent {
    /// A report. Its time is by the process's own clock.
    Report(Box<ReportLine>),
    /// A line on stdout that is no report.
    BadLine {
        /// Its number, from one.
        number: u64,
        /// What is wrong with it.
        cause: String,
    },
    /// It has ended, and all that it wrote has been told.
    Exited(Exit),
}

/// How the process ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exit {
    /// With this status or by this signal.
    Status(ExitStatus),
    /// The system does not tell.
    Unknown,
}

impl Exit {
    /// It ended by itself and says that all is well.
    pub fn is_success(self) -> bool {
        matches!(self, Self::Status(status) if status.success())
    }
}

impl fmt::Display for Exit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Status(status) => status.fmt(f),
            Self::Unknown => f.write_str("no status to be had"),
        }
    }
}

/// What it took to end the process.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum EndedBy {
    /// Nothing: it had ended already.
    Itself,
    /// Its stdin was closed.
    StdinClosed,
    /// SIGTERM.
    Terminated,
    /// SIGKILL.
    Killed,
}

/// How a process was ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ProcessEnd {
    /// What it took.
    pub by: EndedBy,
    /// How it ended.
    pub exit: Exit,
}

/// Why a process was not started.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum SpawnError {
    /// The file for its stderr cannot be made.
    #[error("failed to write {}", path.display())]
    Log {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The system does not start it.
    #[error("failed to start the device under test {program:?}")]
    #[diagnostic(help("{advice}"))]
    Program {
        /// The first word of the command line.
        program: String,
        /// What to look at.
        advice: &'static str,
        /// Why.
        source: io::Error,
    },
}

impl SpawnError {
    fn program(program: &str, source: io::Error) -> Self {
        let advice = match source.kind() {
            io::ErrorKind::NotFound => "is it built, spelt right, and in PATH or given as a path?",
            io::ErrorKind::PermissionDenied => "is it a program, and executable by you (`ls -l`)?",
            _ => "does the command line work in a terminal?",
        };
        Self::Program { program: program.to_owned(), advice, source }
    }
}

/// A running device under test.
#[derive(Debug)]
pub struct DeviceProcess {
    child: Child,
    /// The process group, until the process has ended.
    group: Option<Pid>,
    missions: Option<MissionSender>,
    missions_lost: u64,
    events: mpsc::Receiver<ProcessEvent>,
    stdout_open: bool,
    log: Log,
    exit: Option<Exit>,
}

impl DeviceProcess {
    /// Starts the program that is the first of `words` with the others as arguments, and tells it where `lines` are. It takes
    /// missions on its stdin and reports on its stdout; its stderr goes into `log_file`, which is replaced. Called within a
    /// tokio runtime that has IO enabled.
    ///
    /// # Errors
    /// When the file cannot be made or the program not be started.
    pub fn spawn(words: &[String], lines: &Places, log_file: &Path) -> Result<Self, SpawnError> {
        Self::start(words, lines, (new_log(log_file)?, LOG_BYTES_MAX), true)
    }

    /// The same, for a program that takes no missions: its stdin is empty, and what it writes to stdout is kept in the file
    /// too.
    ///
    /// # Errors
    /// When the file cannot be made or the program not be started.
    pub fn spawn_plain(
        words: &[String],
        lines: &Places,
        log_file: &Path,
    ) -> Result<Self, SpawnError> {
        Self::spawn_into(words, lines, (new_log(log_file)?, LOG_BYTES_MAX))
    }

    /// The same, into an open file that takes so many bytes more.
    ///
    /// # Errors
    /// When the program cannot be started.
    pub fn spawn_into(
        words: &[String],
        lines: &Places,
        log: (File, usize),
    ) -> Result<Self, SpawnError> {
        Self::start(words, lines, log, false)
    }

    fn start(
        words: &[String],
        lines: &Places,
        log: (File, usize),
        talks: bool,
    ) -> Result<Self, SpawnError> {
        let (program, arguments) =
            words.split_first().map_or(("", &[][..]), |(p, a)| (p.as_str(), a));
        let start = || {
            let mut command = Command::new(program);
            let (messages, stderr) = io::pipe()?;
            let pipes = if talks {
                let (stdin, missions) = io::pipe()?;
                let (reports, stdout) = io::pipe()?;
                command.stdin(stdin).stdout(stdout);
                Some((missions, reports))
            } else {
                command.stdin(Stdio::null()).stdout(stderr.try_clone()?);
                None
            };
            command.args(arguments).env(lines::VARIABLE, lines::document(lines));
            command.stderr(stderr).process_group(0).kill_on_drop(true);
            let child = command.spawn()?;
            // The command is dropped by now, and with it our copies of the process's ends.
            Ok((child, pipes, messages))
        };
        let error = |source| SpawnError::program(program, source);
        let (child, pipes, messages) = start().map_err(error)?;
        let group = child.id().and_then(|id| Pid::from_raw(i32::try_from(id).ok()?));
        // From here on dropping it ends the process.
        let (sender, events) = mpsc::channel(pipes::EVENTS_MAX);
        let log = Log::spawn(messages, log).map_err(error)?;
        let mut process = Self {
            child,
            group,
            missions: None,
            missions_lost: 0,
            events,
            stdout_open: talks,
            log,
            exit: None,
        };
        if let Some((missions, reports)) = pipes {
            process.missions = Some(MissionSender::spawn(missions).map_err(error)?);
            pipes::spawn_report_reader(reports, sender).map_err(error)?;
        }
        Ok(process)
    }

    /// Gives it a mission. `false`, and counted, when it does not take any.
    pub fn send(&mut self, mission: &Mission) -> bool {
        let taken = self.missions.as_ref().is_some_and(|missions| missions.send(mission));
        self.missions_lost = self.missions_lost.saturating_add(u64::from(!taken));
        taken
    }

    /// As the kernel numbers it; none once it has ended.
    pub fn id(&self) -> Option<u32> {
        self.child.id()
    }

    /// Missions that it did not take.
    pub const fn missions_lost(&self) -> u64 {
        self.missions_lost
    }

    /// The end of what it wrote to stderr: a few lines, without control characters.
    pub fn last_words(&self) -> String {
        self.log.last_words()
    }

    /// Waits for what comes next. May be called off without losing anything. After
    /// [`ProcessEvent::Exited`] nothing else comes.
    pub async fn next_event(&mut self) -> ProcessEvent {
        loop {
            if let Some(exit) = self.exit {
                return match timeout(REST_WAIT, self.events.recv()).await {
                    Ok(Some(event)) => event,
                    _ => {
                        // Its last words are told with its end.
                        self.log.finish(REST_WAIT).await;
                        ProcessEvent::Exited(exit)
                    }
                };
            }
            tokio::select! {
                biased;
                event = self.events.recv(), if self.stdout_open => match event {
                    Some(event) => return event,
                    None => self.stdout_open = false,
                },
                status = self.child.wait() => {
                    self.exit = Some(status.map_or(Exit::Unknown, Exit::Status));
                    // What it leaves behind would hold on to the ports.
                    self.signal(Signal::KILL);
                    self.group = None;
                }
            }
        }
    }

    /// Sends a signal to it and to all that it has started.
    pub(crate) fn signal(&self, signal: Signal) {
        if let Some(group) = self.group {
            // It may have ended in between, which is what is wanted.
            let _ = kill_process_group(group, signal);
        }
    }

    /// Ends it in order: closes the stdin of one that takes missions, waits, sends SIGTERM, waits, sends SIGKILL. What it
    /// still tells goes to `take`.
    pub async fn end(mut self, mut take: impl FnMut(ProcessEvent)) -> ProcessEnd {
        let close = self.missions.take().map(|_| (EndedBy::StdinClosed, None, CLOSE_WAIT));
        let steps = [
            (EndedBy::Terminated, Some(Signal::TERM), TERMINATE_WAIT),
            (EndedBy::Killed, Some(Signal::KILL), KILL_WAIT),
        ];
        let ended_before = self.exit.is_some();
        let mut end = ProcessEnd { by: EndedBy::Killed, exit: Exit::Unknown };
        for (by, signal, limit) in close.into_iter().chain(steps) {
            if let Some(signal) = signal {
                self.signal(signal);
            }
            if let Ok(exit) = timeout(limit, self.drain(&mut take)).await {
                end = ProcessEnd { by: if ended_before { EndedBy::Itself } else { by }, exit };
                break;
            }
        }
        self.log.finish(REST_WAIT).await;
        end
    }

    async fn drain(&mut self, take: &mut impl FnMut(ProcessEvent)) -> Exit {
        loop {
            match self.next_event().await {
                ProcessEvent::Exited(exit) => return exit,
                event => take(event),
            }
        }
    }
}

/// A file for what a program writes, in the place of one from before.
fn new_log(path: &Path) -> Result<File, SpawnError> {
    File::create(path).map_err(|source| SpawnError::Log { path: path.to_owned(), source })
}

impl Drop for DeviceProcess {
    fn drop(&mut self) {
        self.signal(Signal::KILL);
    }
}
