//! A device under test in its own process: missions go to its stdin and reports come from its stdout, one JSON line
//! each ([`controller::mission`]); its stderr is kept in a file.
//!
//! Nothing here blocks on the process: missions that it does not take are counted, and unfetched reports wait in the
//! pipe. It is the leader of a process group, so that a wrapper such as `sh` or `cargo run` ends together with its
//! children, and so that Ctrl-C in the terminal reaches only the harness, which then ends the process in order.

mod group;
mod pipes;
#[cfg(test)]
mod tests;
mod unread;

pub use pipes::{
    LINE_BYTES_MAX, LOG_BYTES_MAX, LineEnd, ReportedLine, line_of, next_line, report_of,
};
pub use unread::Unread;

use super::command::can_start;
use super::lines::{self, Places};
use controller::mission::Mission;
use group::Group;
pub use group::kill_all;
#[cfg(feature = "programs")]
pub(crate) use pipes::last_lines;
use pipes::{Log, MissionSender};
use rustix::process::Signal;
use std::fmt;
use std::fs::File;
use std::io;
use std::os::unix::process::ExitStatusExt as _;
use std::path::{Path, PathBuf};
use std::process::ExitStatus;
use std::process::Stdio;
use std::time::Duration;
use tokio::process::{Child, Command};
use tokio::sync::mpsc;
use tokio::time::timeout;

/// Time limit to end after its stdin is closed. Assumption: two seconds in which our controller brings the base to
/// rest, one to write what is left, and as much again.
pub const CLOSE_WAIT: Duration = Duration::from_secs(6);
/// Time limit to end after SIGTERM. Assumption: as above, without the reserve.
pub const TERMINATE_WAIT: Duration = Duration::from_secs(3);
/// Time limit of the system after SIGKILL.
pub const KILL_WAIT: Duration = Duration::from_secs(5);
/// Time limit for its output to arrive after its end.
const REST_WAIT: Duration = Duration::from_millis(500);
const SIGTERM: i32 = 15;

#[derive(Debug, Clone, PartialEq)]
pub enum ProcessEvent {
    /// A line on stdout.
    Line(ReportedLine),
    /// It has ended, and all of its output has been passed on.
    Exited(Exit),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exit {
    /// With this status or signal.
    Status(ExitStatus),
    /// The system does not say.
    Unknown,
}

impl Exit {
    pub fn is_success(self) -> bool {
        matches!(self, Self::Status(status) if status.success())
    }

    /// In brackets, or behind `by`: `status 3`, `signal 9 (SIGKILL)`.
    pub fn brief(self) -> String {
        let text = self.to_string();
        text.replacen("exit status: ", "status ", 1).replacen("signal: ", "signal ", 1)
    }

    /// What is to be noted, behind its name, of an end after SIGTERM. Status 0 and the signal itself are in order; shells
    /// and virtual machines pass the signal on as status 143.
    pub fn when_asked(self) -> Option<String> {
        let Self::Status(status) = self else { return None };
        let did = match (status.code(), status.signal()) {
            (Some(0 | 143), _) | (_, Some(SIGTERM)) => return None,
            (Some(code), _) => format!("ended with status {code}"),
            (None, _) => format!("was killed by {}", self.brief().replace(" (core dumped)", "")),
        };
        Some(format!("{did} when it was asked to end"))
    }

    /// What it did, behind its name.
    pub fn in_words(self) -> String {
        match self {
            Self::Status(status) if status.code().is_none() => {
                format!("was ended during the run by {}", self.brief())
            }
            Self::Status(_) | Self::Unknown => {
                format!("exited during the run ({})", self.brief())
            }
        }
    }
}

impl ProcessEnd {
    /// What is to be noted, behind its name, of how it ended when it was asked to.
    pub fn noted(self) -> Option<String> {
        match self.by {
            EndedBy::Terminated => self.exit.when_asked(),
            EndedBy::Killed => Some(killed_after(TERMINATE_WAIT)),
            EndedBy::Itself | EndedBy::StdinClosed => None,
        }
    }
}

pub fn killed_after(limit: Duration) -> String {
    format!("did not end within {} s of SIGTERM and was killed", limit.as_secs_f64())
}

impl fmt::Display for Exit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Status(status) => status.fmt(f),
            Self::Unknown => f.write_str("no status to be had"),
        }
    }
}

/// The measure that ended the process.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum EndedBy {
    /// None: it had ended already.
    Itself,
    StdinClosed,
    Terminated,
    Killed,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ProcessEnd {
    pub by: EndedBy,
    pub exit: Exit,
}

#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum SpawnError {
    /// The file for its stderr cannot be created.
    #[error("failed to write {}", path.display())]
    Log { path: PathBuf, source: io::Error },
    #[error("failed to start the device under test {program:?}")]
    #[diagnostic(help("{advice}"))]
    Program {
        /// The first word of the command line.
        program: String,
        advice: &'static str,
        source: io::Error,
    },
}

impl SpawnError {
    fn program(program: &str, source: io::Error) -> Self {
        let advice = match source.kind() {
            io::ErrorKind::NotFound => "check the spelling and the PATH",
            io::ErrorKind::PermissionDenied => "is it a program, and executable by you (`ls -l`)?",
            _ => "does the command line work in a terminal?",
        };
        Self::Program { program: program.to_owned(), advice, source }
    }
}

#[derive(Debug)]
pub struct DeviceProcess {
    child: Child,
    /// The process group, until the process has ended.
    group: Option<Group>,
    missions: Option<MissionSender>,
    missions_lost: u64,
    events: mpsc::Receiver<ProcessEvent>,
    stdout_open: bool,
    log: Log,
    exit: Option<Exit>,
}

impl DeviceProcess {
    /// Starts the first of `words` as a program with the other words as arguments, and passes it the ports of `lines`.
    /// One that `talks` takes missions on its stdin and reports on its stdout; the stdin of another is empty, and its
    /// stdout is kept with its stderr. The stderr goes into the file, which takes so many bytes more. Needs a tokio
    /// runtime with IO enabled.
    ///
    /// # Errors
    /// When the program cannot be started.
    pub fn spawn(
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
        can_start(words)
            .map_err(|reason| error(io::Error::new(io::ErrorKind::NotFound, reason)))?;
        let (child, pipes, messages) = start().map_err(error)?;
        let group = Group::led_by(&child);
        // From here on dropping the value ends the process.
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

    /// Sends a mission; returns `false`, and counts it, if the process does not take it.
    pub fn send(&mut self, mission: &Mission) -> bool {
        let taken = self.missions.as_ref().is_some_and(|missions| missions.send(mission));
        self.missions_lost = self.missions_lost.saturating_add(u64::from(!taken));
        taken
    }

    /// Process id; `None` once it has ended.
    pub fn id(&self) -> Option<u32> {
        self.child.id()
    }

    /// Number of missions that it did not take.
    pub const fn missions_lost(&self) -> u64 {
        self.missions_lost
    }

    /// The last few lines of its stderr, without control characters.
    pub fn last_words(&self) -> String {
        self.log.last_words()
    }

    /// Waits for the next event. Cancel-safe. After [`ProcessEvent::Exited`] no more events come.
    pub async fn next_event(&mut self) -> ProcessEvent {
        loop {
            if let Some(exit) = self.exit {
                return match timeout(REST_WAIT, self.events.recv()).await {
                    Ok(Some(event)) => event,
                    _ => {
                        // The last words are complete before its end is reported.
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
                    // Processes that it leaves behind would keep the ports open.
                    self.signal(Signal::KILL);
                    self.group = None;
                }
            }
        }
    }

    /// Sends a signal to it and to all that it has started.
    pub(crate) fn signal(&self, signal: Signal) {
        if let Some(group) = &self.group {
            group.signal(signal);
        }
    }

    /// Ends it in order: closes the stdin of one that takes missions, waits, sends SIGTERM, waits, sends SIGKILL.
    /// Passes its remaining events to `take`.
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

/// A file for what a program writes, behind what it holds already if it is `kept`.
///
/// # Errors
/// When the file cannot be created.
pub fn log_file(path: &Path, kept: bool) -> Result<(File, usize), SpawnError> {
    let file = File::options().write(true).create(true).append(kept).truncate(!kept).open(path);
    let file = file.map_err(|source| SpawnError::Log { path: path.to_owned(), source })?;
    Ok((file, LOG_BYTES_MAX))
}

impl Drop for DeviceProcess {
    fn drop(&mut self) {
        self.signal(Signal::KILL);
    }
}
