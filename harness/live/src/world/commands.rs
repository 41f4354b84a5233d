//! Carries out what a bench does by commands of its own: one after another, each in a process group that ends with it.

use super::LiveWorld;
use super::bench_work::BenchWork;
use super::clock::{Alarm, Clock};
use super::error::LiveError;
use super::journal::{Work, note};
use crate::lines::Places;
use crate::process::{
    DeviceProcess, Exit, LOG_BYTES_MAX, ProcessEvent, SpawnError, TERMINATE_WAIT,
};
use plan::Name;
use record::outcome::CommandSummary;
use record::{Device, Progress};
use rig::director::Director;
use rig::{Pulse, Sink};
use rustix::process::Signal;
use std::collections::BTreeSet;
use std::fs::OpenOptions;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use wire::time::{Span, Timestamp};

/// Interval between checks for a stop request.
const LOOK_PERIOD: Span = Span::from_millis(100);

/// The file beside the record that keeps what a command writes; `log` is that of the device under test.
fn file_of(log: &Path, name: &str) -> PathBuf {
    log.with_file_name(format!("command-{name}.log"))
}

#[derive(Debug)]
pub(super) struct Ended {
    name: String,
    since: Timestamp,
    /// How it ended, for the summary.
    how: String,
    /// Why that is not well.
    why: Option<String>,
}

impl Ended {
    fn took_s(&self, now: Timestamp) -> f64 {
        (now - self.since).as_secs_f64()
    }
}

enum Undone {
    /// One of them failed: why.
    Failed(String),
    Stopped,
}

impl From<io::Error> for Undone {
    fn from(error: io::Error) -> Self {
        Self::Failed(error.to_string())
    }
}

/// What becomes of a command that takes too long.
#[derive(Debug, Clone, Copy)]
enum Overdue {
    /// It may go on until then.
    At(Timestamp),
    /// It was told to end, and is killed then.
    Told(Timestamp),
    Killed,
}

#[derive(Debug)]
struct Running {
    name: String,
    process: DeviceProcess,
    since: Timestamp,
    limit: Span,
    overdue: Overdue,
}

#[derive(Debug)]
pub(super) struct Commands {
    work: BenchWork,
    log: PathBuf,
    /// Where lines are; none before the ports are open.
    pub(super) places: Places,
    /// Those whose file is of this run.
    begun: BTreeSet<String>,
    running: Option<Running>,
}

impl Commands {
    /// What they write goes beside `log`.
    pub(super) fn new(work: BenchWork, log: &Path) -> Self {
        let (log, places) = (log.to_owned(), Places::new());
        Self { work, log, places, begun: BTreeSet::new(), running: None }
    }

    /// Starts the command of that name; `when` is for the head of what it writes.
    ///
    /// # Errors
    /// Why it cannot, in a sentence.
    pub(super) fn start(&mut self, now: Timestamp, when: &str, name: &str) -> Result<(), String> {
        let known = Name::new(name).and_then(|name| self.work.commands.get(&name));
        let command = known.ok_or_else(|| format!("the bench has no command `{name}`"))?;
        let path = file_of(&self.log, name);
        let unwritten = |error: io::Error| format!("failed to write {}: {error}", path.display());
        let is_new = self.begun.insert(name.to_owned());
        let mut options = OpenOptions::new();
        options.create(true).write(true).truncate(is_new).append(!is_new);
        let mut file = options.open(&path).map_err(unwritten)?;
        let written = usize::try_from(file.metadata().map_err(unwritten)?.len());
        let room = LOG_BYTES_MAX.saturating_sub(written.unwrap_or(LOG_BYTES_MAX));
        if room > 0 {
            let words = command.run.join(" ").replace(char::is_control, "?");
            writeln!(file, "# {when}: {words}").map_err(unwritten)?;
        }
        let process = DeviceProcess::spawn(&command.run, &self.places, (file, room), false);
        let process = process.map_err(|error| match error {
            SpawnError::Program { program, source, .. } => {
                format!("failed to start {program:?} for the bench command `{name}`: {source}")
            }
            log @ SpawnError::Log { .. } => log.to_string(),
        })?;
        let (limit, overdue) = (command.time_limit, Overdue::At(now + command.time_limit));
        self.running = Some(Running { name: name.to_owned(), process, since: now, limit, overdue });
        Ok(())
    }

    /// When [`Self::wake`] has something to do.
    pub(super) fn next_wakeup(&self) -> Timestamp {
        match self.running.as_ref().map(|running| running.overdue) {
            Some(Overdue::At(at) | Overdue::Told(at)) => at,
            Some(Overdue::Killed) | None => Timestamp::MAX,
        }
    }

    /// Ends what has taken too long, with all that it has started.
    pub(super) fn wake(&mut self, now: Timestamp) {
        let Some(running) = &mut self.running else { return };
        match running.overdue {
            Overdue::At(at) if now >= at => {
                running.process.signal(Signal::TERM);
                let wait = Span::from_secs_f64(TERMINATE_WAIT.as_secs_f64());
                running.overdue = Overdue::Told(now + wait);
            }
            Overdue::Told(at) if now >= at => {
                running.process.signal(Signal::KILL);
                running.overdue = Overdue::Killed;
            }
            _ => {}
        }
    }

    /// Waits until the command that runs has ended. May be called off without losing anything.
    pub(super) async fn ended(&mut self) -> Ended {
        loop {
            let Some(running) = &mut self.running else { return std::future::pending().await };
            let ProcessEvent::Exited(exit) = running.process.next_event().await else { continue };
            if let Some(running) = self.running.take() {
                return running.told(exit);
            }
        }
    }

    /// The run is over: so is the command. What became of it, where one still ran.
    pub(super) async fn end(&mut self) -> Option<Ended> {
        let Running { name, process, since, .. } = self.running.take()?;
        let exit = process.end(|_| {}).await.exit;
        Some(Ended { name, since, how: format!("ended with the run, {exit}"), why: None })
    }

    /// Carries these out, one after another; the first that fails is the last. Each that has ended is `told`.
    async fn one_by_one(
        &mut self,
        names: &[Name],
        when: &str,
        told: &mut impl FnMut(&Ended, f64),
        goes_on: &mut impl FnMut() -> bool,
    ) -> Result<(), Undone> {
        if names.is_empty() {
            return Ok(());
        }
        let clock = Clock::start();
        let alarm = Alarm::new(clock)?;
        for name in names {
            self.start(clock.now(), when, name.as_str()).map_err(Undone::Failed)?;
            let ended = loop {
                if !goes_on() {
                    self.end().await;
                    return Err(Undone::Stopped);
                }
                let due = self.next_wakeup().min(clock.now() + LOOK_PERIOD);
                tokio::select! {
                    rung = alarm.at(due) => rung?,
                    ended = self.ended() => break ended,
                }
                self.wake(clock.now());
            };
            told(&ended, ended.took_s(clock.now()));
            ended.why.map_or(Ok(()), |why| Err(Undone::Failed(why)))?;
        }
        Ok(())
    }

    pub(super) fn files(&self) -> impl Iterator<Item = String> {
        let files = self.begun.iter().map(|name| file_of(&self.log, name));
        files.filter_map(|path| Some(path.file_name()?.to_str()?.to_owned()))
    }
}

fn tell(director: &mut Director, sink: Sink<'_>, now: Timestamp, ended: &Ended, took_s: f64) {
    let Ended { name, how, .. } = ended;
    CommandSummary::ran(&mut director.commands, name, took_s, how);
    note(sink, now, Device::Plan, format!("`{name}`: {how}, after {took_s:.3} s"));
}

impl LiveWorld {
    /// Has the bench do what is to be done before a port is opened.
    pub(super) async fn set_up(
        &mut self,
        commands: &mut Commands,
        sink: Sink<'_>,
        pulse: Pulse<'_>,
    ) -> Result<(), LiveError> {
        let now = Timestamp::ZERO;
        let (steps_done, steps) = self.director.engine.progress();
        let mut goes_on = || pulse(Progress { now, steps_done, steps });
        let mut told = |ended: &Ended, took_s| tell(&mut self.director, sink, now, ended, took_s);
        let names = commands.work.setup.clone();
        let done = commands.one_by_one(&names, "before the run", &mut told, &mut goes_on).await;
        if !names.is_empty() {
            self.journal.work = Work::Done(now);
        }
        done.map_err(|undone| match undone {
            Undone::Stopped => LiveError::Stopped,
            Undone::Failed(why) => {
                let folder = commands.log.parent().unwrap_or(Path::new("."));
                LiveError::Setup { why, folder: folder.to_owned() }
            }
        })
    }

    /// Has the bench do what is to be done once the ports are closed, at the end of a run or where it could not begin.
    pub(super) async fn tear_down(
        &mut self,
        commands: &mut Commands,
        sink: Sink<'_>,
        now: Timestamp,
    ) -> Result<(), String> {
        let mut told = |ended: &Ended, took_s| tell(&mut self.director, sink, now, ended, took_s);
        let names = commands.work.teardown.clone();
        match commands.one_by_one(&names, "after the run", &mut told, &mut || true).await {
            Err(Undone::Failed(why)) => Err(why),
            Err(Undone::Stopped) | Ok(()) => Ok(()),
        }
    }

    /// Takes what came of a command that the plan asked for.
    pub(super) fn hear_command(&mut self, now: Timestamp, sink: Sink<'_>, ended: &Ended) {
        tell(&mut self.director, sink, now, ended, ended.took_s(now));
        self.journal.work = Work::Done(now);
        match &ended.why {
            Some(why) => self.director.engine.broke(now, why),
            None => self.director.engine.answered(now),
        }
    }
}

impl Running {
    /// Describes how the command ended.
    fn told(self, exit: Exit) -> Ended {
        let Self { name, process, since, limit, overdue } = self;
        let last = process.last_words();
        let last = match last.trim() {
            "" => String::new(),
            words => format!(": {words}"),
        };
        let limit = limit.as_secs_f64();
        let (how, why) = match overdue {
            Overdue::At(_) if exit.is_success() => (exit.to_string(), None),
            Overdue::At(_) => {
                let status = exit.brief();
                let why = format!("the bench command `{name}` failed ({status}){last}");
                (exit.to_string(), Some(why))
            }
            Overdue::Told(_) | Overdue::Killed => (
                format!("ended after its limit, {exit}"),
                Some(format!(
                    "the bench command `{name}` took longer than its limit of {limit} s{last}"
                )),
            ),
        };
        Ended { name, since, how, why }
    }
}
