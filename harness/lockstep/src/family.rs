//! A program's processes. Each has a link; one runs at a time, in order of age, until none can go on.

use crate::binary::{self, BinaryError, Way};
use crate::link::{Clocks, Link, Message, PATIENCE, Reading, SentFrame, Turn};
use crate::outside::{Given, Outside};
use crate::spawned::{Spawned, is_gone, wait_for_death};
use crate::state::Ended;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, Signal, kill_process};
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::net::UnixListener;
use std::process::ExitStatus;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use wire::time::Timestamp;

/// Most turns at one instant. Assumption: processes that pass something on this often without waiting for time will do
/// so endlessly.
const TURNS_MAX: u32 = 50_000;
/// Status with which the shim ends a process that has lost its link.
const LINK_LOST: i32 = 121;

/// Limits of a family, and the configuration of its processes.
#[derive(Debug)]
pub(crate) struct Rules {
    /// Longest real time without waiting.
    pub limit: Duration,
    /// Set when a process that does not wait is to be killed at once.
    pub stop: Arc<AtomicBool>,
    /// Most processes at once.
    pub processes_max: usize,
    /// Whether its standard input is used to talk.
    pub talks: bool,
    /// Configuration for each process that joins, except the time.
    pub declarations: String,
}

#[derive(Debug)]
struct Process {
    pid: i32,
    link: Link,
    deadline: i64,
    stuck: Option<u32>,
    inbox: Vec<SentFrame>,
    bytes_came: bool,
    signal: u32,
    is_replacing_itself: bool,
}

/// The processes of a program.
#[derive(Debug)]
pub(crate) struct Family {
    rules: Rules,
    listener: UnixListener,
    first: Spawned,
    /// By age.
    processes: BTreeMap<u32, Process>,
    born: u32,
    clocks: Clocks,
}

impl Family {
    /// Takes the started process into the family, as soon as it has loaded the shim.
    pub(crate) fn start(
        rules: Rules,
        listener: UnixListener,
        first: Spawned,
    ) -> Result<Self, Ended> {
        let pid = first.pid();
        let (processes, clocks) = (BTreeMap::new(), Clocks::default());
        let mut family = Self { rules, listener, first, processes, born: 0, clocks };
        match family.join(pid)? {
            Some(link) => family.add(pid, link),
            None => {
                let status = family.first.wait(family.rules.limit);
                return Err(match status {
                    Some(status) if !status.success() => Ended::Exited(status),
                    _ => family.never_joined(pid),
                });
            }
        };
        Ok(family)
    }

    /// The earliest time that a process waits for.
    pub(crate) fn deadline(&self) -> i64 {
        self.processes.values().map(|process| process.deadline).min().unwrap_or(i64::MAX)
    }

    /// Lets every process run until all of them wait.
    pub(crate) fn run(&mut self, given: &Given, outside: &mut impl Outside) -> Result<(), Ended> {
        self.clocks = given.clocks;
        for process in self.processes.values_mut() {
            process.inbox.extend_from_slice(&given.frames);
            process.bytes_came |= given.bytes_came;
        }
        if let Some(mut eldest) = self.processes.first_entry() {
            eldest.get_mut().signal = given.signal;
        }
        // Each must have found nothing to do since another last did something.
        let (mut last, mut quiet) = (None, 0);
        for _ in 0..TURNS_MAX {
            let Some(next) = self.after(last) else { return Err(self.all_gone()) };
            let known = self.born;
            let progressed = self.turn(next, outside)?;
            // A new process must run; the end of a process matters to the others.
            let has_changed = self.born != known || !self.processes.contains_key(&next);
            quiet = match (has_changed, progressed) {
                (true, _) => 0,
                (false, true) => 1,
                (false, false) => quiet + 1,
            };
            last = Some(next);
            let has_mail = self.processes.values().any(|process| !process.inbox.is_empty());
            if quiet >= self.processes.len() && !has_mail {
                return match (self.processes.is_empty(), self.stuck()) {
                    (true, _) => Err(self.all_gone()),
                    (false, Some(threads @ 1..)) => Err(Ended::Deadlocked {
                        threads,
                        since: Timestamp::from_nanos(self.clocks.now),
                    }),
                    (false, _) => Ok(()),
                };
            }
        }
        Err(Ended::NeverAdvanced)
    }

    /// Kills all processes at once; returns the exit status of the first one.
    pub(crate) fn kill(&mut self) -> Option<ExitStatus> {
        self.first.kill();
        for process in self.processes.values() {
            // Some may have left the process group.
            if let Some(pid) = Pid::from_raw(process.pid) {
                let _ = kill_process(pid, Signal::KILL);
            }
        }
        for (_, process) in std::mem::take(&mut self.processes) {
            if process.pid != self.first.pid() {
                wait_for_death(process.pid, self.rules.limit);
            }
        }
        self.first.wait(self.rules.limit)
    }

    /// Process ids of the living processes.
    pub(crate) fn pids(&self) -> impl Iterator<Item = i32> {
        self.processes.values().map(|process| process.pid)
    }

    /// The number of threads that wait for each other, if nothing else can let any of them go on.
    fn stuck(&self) -> Option<u32> {
        self.processes.values().map(|process| process.stuck).sum()
    }

    fn after(&self, last: Option<u32>) -> Option<u32> {
        let later = last.and_then(|last| self.processes.range(last + 1..).next());
        later.or_else(|| self.processes.first_key_value()).map(|(key, _)| *key)
    }

    fn add(&mut self, pid: i32, link: Link) -> u32 {
        self.born += 1;
        let process = Process {
            pid,
            link,
            deadline: self.clocks.now,
            stuck: None,
            inbox: Vec::new(),
            bytes_came: false,
            signal: 0,
            is_replacing_itself: false,
        };
        self.processes.insert(self.born, process);
        self.born
    }

    /// Lets one process run until it waits or ends; returns whether it did anything.
    fn turn(&mut self, key: u32, outside: &mut impl Outside) -> Result<bool, Ended> {
        self.let_run(key);
        let mut silence = Duration::ZERO;
        loop {
            let Some(process) = self.processes.get_mut(&key) else { return Ok(true) };
            match process.link.read() {
                Reading::Message(Message::Idle { deadline, progressed, stuck }) => {
                    (process.deadline, process.stuck) = (deadline, stuck);
                    outside.paused();
                    return Ok(progressed);
                }
                Reading::Message(message) => {
                    silence = Duration::ZERO;
                    self.take(key, message, outside)?;
                }
                Reading::Silence => {
                    let pid = process.pid;
                    if !self.is_held(pid) {
                        silence += PATIENCE;
                    }
                    if self.rules.stop.load(Ordering::Relaxed) {
                        return Err(Ended::GivenUp);
                    }
                    if silence >= self.rules.limit {
                        return Err(Ended::NeverWaited { limit: self.rules.limit });
                    }
                    // It may wait, invisibly for the shim, for a process that it also started invisibly.
                    while let Some((pid, link)) = self.accept(Duration::ZERO)? {
                        let stranger = self.add(pid, link);
                        self.turn(stranger, outside)?;
                    }
                }
                Reading::End => {
                    outside.paused();
                    if self.leave(key)? {
                        return Ok(true);
                    }
                    self.let_run(key);
                }
            }
        }
    }

    fn let_run(&mut self, key: u32) {
        let clocks = self.clocks;
        let Some(process) = self.processes.get_mut(&key) else { return };
        let turn = Turn {
            clocks,
            signal: std::mem::take(&mut process.signal),
            bytes_came: std::mem::take(&mut process.bytes_came),
            frames: std::mem::take(&mut process.inbox),
        };
        // If the process is gone, reading from its link will show it.
        let _ = process.link.run(&turn);
    }

    fn take(
        &mut self,
        key: u32,
        message: Message,
        outside: &mut impl Outside,
    ) -> Result<(), Ended> {
        let limit = self.rules.processes_max;
        let may = match message {
            Message::Frame(sent) => {
                outside.frame(&sent);
                let others = self.processes.iter_mut().filter(|(other, _)| **other != key);
                others.filter(|_| sent.is_local).for_each(|(_, other)| other.inbox.push(sent));
                return Ok(());
            }
            Message::Serial(number, change) => {
                outside.serial(number, change);
                return Ok(());
            }
            Message::Unsent(number) => {
                let unsent = outside.unsent(number);
                if let Some(process) = self.processes.get_mut(&key) {
                    let _ = process.link.tell_unsent(unsent);
                }
                return Ok(());
            }
            Message::Fork { others } => self.processes.len().saturating_add(others) < limit,
            Message::Forked { pid } => {
                if let Some(link) = if pid > 0 { self.join(pid)? } else { None } {
                    self.add(pid, link);
                }
                true
            }
            Message::Exec | Message::ExecFailed => {
                if let Some(process) = self.processes.get_mut(&key) {
                    process.is_replacing_itself = message == Message::Exec;
                }
                true
            }
            Message::Hello { .. } | Message::Idle { .. } => return Err(Ended::LinkClosed),
        };
        if let Some(process) = self.processes.get_mut(&key) {
            let _ = process.link.answer(may);
        }
        if may { Ok(()) } else { Err(Ended::TooManyProcesses { limit }) }
    }

    /// A process hung up: it has replaced itself and joins again (`false`), or it has ended (`true`).
    fn leave(&mut self, key: u32) -> Result<bool, Ended> {
        let Some(process) = self.processes.get_mut(&key) else { return Ok(true) };
        let pid = process.pid;
        if std::mem::take(&mut process.is_replacing_itself)
            && let Some(link) = self.join(pid)?
            && let Some(process) = self.processes.get_mut(&key)
        {
            process.link = link;
            return Ok(false);
        }
        // Its files are closed one by one: others see the same in every run only when it is completely gone.
        let is_dead = if pid == self.first.pid() {
            let status = self.first.wait(self.rules.limit);
            status.is_some_and(|status| status.code() != Some(LINK_LOST))
        } else {
            wait_for_death(pid, self.rules.limit)
        };
        self.processes.remove(&key);
        if is_dead { Ok(true) } else { Err(Ended::LinkClosed) }
    }

    fn all_gone(&mut self) -> Ended {
        match self.first.wait(self.rules.limit) {
            Some(status) => Ended::Exited(status),
            None => Ended::LinkClosed,
        }
    }

    /// Waits for a process to join; `None` if it has ended instead. Accepts others that come meanwhile.
    fn join(&mut self, pid: i32) -> Result<Option<Link>, Ended> {
        let mut waited = Duration::ZERO;
        while waited < self.rules.limit {
            match self.accept(PATIENCE)? {
                Some((found, link)) if found == pid => return Ok(Some(link)),
                Some((other, link)) => {
                    self.add(other, link);
                }
                None => {
                    waited += PATIENCE;
                    if is_gone(pid) {
                        return Ok(None);
                    }
                    let executable = format!("/proc/{pid}/exe");
                    let checked = binary::check(executable.as_ref());
                    if matches!(
                        checked,
                        Ok(Way::Tracer) | Err(BinaryError::NoShim(_) | BinaryError::Privileged(_))
                    ) {
                        break;
                    }
                }
            }
        }
        Err(self.never_joined(pid))
    }

    /// Whether a debugger from outside holds a process; such a process is awaited without limit.
    fn is_held(&self, pid: i32) -> bool {
        let status = fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
        let value =
            |key: &str| status.lines().find_map(|line| line.strip_prefix(key)).map(str::trim);
        let tracer = value("TracerPid:").and_then(|pid| pid.parse().ok());
        let is_ours = self.processes.values().any(|process| Some(process.pid) == tracer);
        value("State:").is_some_and(|state| state.starts_with('t')) && !is_ours
    }

    fn never_joined(&self, pid: i32) -> Ended {
        let link = fs::read_link(format!("/proc/{pid}/exe"));
        let executable = link.map_or_else(|_| "gone".to_owned(), |path| path.display().to_string());
        Ended::NeverJoined { pid, executable }
    }

    /// Accepts and configures the next process that connects within `limit`.
    fn accept(&self, limit: Duration) -> Result<Option<(i32, Link)>, Ended> {
        let limit = Timespec { tv_sec: 0, tv_nsec: i64::from(limit.subsec_nanos()) };
        let mut ends = [PollFd::new(&self.listener, PollFlags::IN)];
        if !matches!(poll(&mut ends, Some(&limit)), Ok(1..)) {
            return Ok(None);
        }
        let accepted = self.listener.accept().and_then(|(stream, _)| Link::new(stream));
        let Ok(mut link) = accepted else { return Ok(None) };
        let mut waited = Duration::ZERO;
        while waited < self.rules.limit {
            match link.read() {
                Reading::Message(Message::Hello { pid }) => {
                    let first = match (pid == self.first.pid(), self.rules.talks) {
                        (true, true) => "first \ntalks \n",
                        (true, false) => "first \n",
                        (false, _) => "",
                    };
                    let text =
                        format!("{}{first}now {}\n", self.rules.declarations, self.clocks.now);
                    return Ok(link.configure(&text).is_ok().then_some((pid, link)));
                }
                Reading::Silence => waited += PATIENCE,
                Reading::Message(_) | Reading::End => break,
            }
        }
        Ok(None)
    }
}

impl Drop for Family {
    fn drop(&mut self) {
        self.kill();
    }
}
