//! A user's program in step with the world.

use super::uarts::Uarts;
use crate::command::{can_start, fill};
use crate::lines::{self, Place, Places};
use crate::process::{Exit, killed_after, last_lines};
use described::Medium;
use lockstep::{BinaryError, Ended, Lockstep, Output, Program, StartError};
use plan::Rig;
use plan::rig::{NodePart, RigLine, RigNode, UnderTest, VirtualTime};
use rig::hosted::NodeDevice;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;
use wire::can::BitRates;
use wire::device::{Device, PortId, Transmit};
use wire::serial::SerialSettings;
use wire::time::{Span, Timestamp};

/// Time for a program to end after SIGTERM, as on a bench.
pub(super) const STOPPING: Span = Span::from_secs(3);

/// Longest interface name (`IFNAMSIZ`).
const INTERFACE_BYTES_MAX: usize = 15;

/// Starts the program of a node by its place; `None` if the node is not a program. Its output goes to `log`. It is killed
/// once `stop` is set and it does not wait.
pub fn start(
    (log, stop): (Option<&Path>, &Arc<AtomicBool>),
    rig: &Rig,
    place: usize,
) -> Option<Result<Box<dyn NodeDevice>, String>> {
    let node = &rig.nodes[place];
    let NodePart::UnderTest(UnderTest::Command(words)) = &node.part else { return None };
    let started = started((log, stop), rig, node, words);
    Some(started.map(|running| Box::new(running) as Box<dyn NodeDevice>))
}

fn started(
    (log, stop): (Option<&Path>, &Arc<AtomicBool>),
    rig: &Rig,
    node: &RigNode,
    words: &[String],
) -> Result<InStep, String> {
    let lines = 0..rig.robot_lines() + rig.lines.len();
    let ports: BTreeMap<String, String> =
        lines.map(|line| (rig.line_name(line).to_owned(), port(rig, line))).collect();
    let words = fill(words, &ports).map_err(|error| error.to_string())?;
    can_start(&words).map_err(|reason| format!("failed to start `{}`: {reason}", node.name))?;
    let (mut ports, mut places, mut uarts) = (Vec::new(), Places::new(), Uarts::default());
    for line in &node.lines {
        let name = port(rig, *line);
        places.insert(rig.line_name(*line).to_owned(), place(rig, *line, &name));
        let kind = match declared(rig, *line) {
            Some(RigLine { medium: Medium::Serial(settings), .. }) => {
                uarts.add(PortId(ports.len() as u8), rig.line_name(*line), *settings);
                PortKind::Serial(*settings)
            }
            Some(RigLine { data_bit_rate: Some(_), .. }) => PortKind::CanFd,
            _ => PortKind::Can,
        };
        ports.push((name, kind));
    }
    let is_alone = rig.under_test().count() == 1;
    let log = log.map(|log| match is_alone {
        true => log.to_owned(),
        false => log.with_extension(format!("{}.log", node.name)),
    });
    let limits = node.virtual_time;
    let places = lines::document(&places);
    let how = How { words, ports, places, limits, log, stop: Arc::clone(stop) };
    let running = how.start(false).map_err(|error| why(&node.name, &error))?;
    let (name, now, ahead) = (node.name.clone(), Timestamp::ZERO, Span::ZERO);
    Ok(InStep {
        name,
        how,
        running,
        uarts,
        now,
        ahead,
        not_started: None,
        is_told: false,
        is_over: false,
    })
}

/// How a program is started, each time that its supply comes on.
#[derive(Debug)]
struct How {
    words: Vec<String>,
    ports: Vec<(String, PortKind)>,
    /// The document of its lines.
    places: String,
    limits: VirtualTime,
    log: Option<PathBuf>,
    stop: Arc<AtomicBool>,
}

#[derive(Debug, Clone, Copy)]
enum PortKind {
    Serial(SerialSettings),
    Can,
    CanFd,
}

impl How {
    /// Starts the program; `again` keeps what is in its log.
    fn start(&self, again: bool) -> Result<Lockstep, StartError> {
        let mut program = in_words(self.words.clone());
        for (name, kind) in &self.ports {
            program = match kind {
                PortKind::Serial(settings) => program.serial_at(name, *settings),
                PortKind::Can => program.can(name),
                PortKind::CanFd => program.can_fd(name),
            };
        }
        program = limited(program, &self.limits).until(Arc::clone(&self.stop));
        program = program.env(lines::VARIABLE, &self.places);
        if let Some(log) = self.log.clone() {
            program = program.output(if again { Output::Appended(log) } else { Output::File(log) });
        }
        program.start()
    }
}

fn limited(mut program: Program, said: &VirtualTime) -> Program {
    if let Some(limit_s) = said.wall_limit_s {
        program = program.wall_limit(Duration::from_secs_f64(limit_s));
    }
    if let Some(count) = said.processes_max {
        program = program.processes_max(count as usize);
    }
    if let Some(questions) = said.spin_questions {
        program = program.spin_questions(questions);
    }
    match said.spin_step_s {
        Some(step_s) => program.spin_step(Span::from_secs_f64(step_s)),
        None => program,
    }
}

/// The program with this command line.
pub(super) fn in_words(words: Vec<String>) -> Program {
    let program = Program::new(words);
    // Random numbers from the system would differ from run to run.
    match std::env::var_os("PYTHONHASHSEED") {
        None => program.env("PYTHONHASHSEED", "0"),
        Some(_) => program,
    }
}

/// A message why the program of `name` does not start.
pub(super) fn why(name: &str, error: &StartError) -> String {
    if let StartError::Binary(BinaryError::Missing(program)) = error {
        return format!(
            "failed to start `{name}`: cannot find {program:?}: check the spelling and the PATH"
        );
    }
    let cause = std::error::Error::source(error).map(|cause| format!(": {cause}"));
    format!("failed to start `{name}`: {error}{}", cause.unwrap_or_default())
}

/// Lines of output that say why a program ended. Assumption: a warning or two of what is torn down come after the cause.
const LAST_LINES: usize = 3;

/// What says why a program ended: the exception of its last traceback, after which Python may print warnings of what it tears
/// down; else its last lines.
fn telling(words: &str) -> Option<String> {
    let traced = words.rsplit_once("Traceback (most recent call last):\n").map(|(_, after)| after);
    let mut after = traced.unwrap_or_default().lines();
    let exception = after.find(|line| !line.starts_with(' ') && !line.is_empty());
    if let Some(exception) = exception {
        return Some(exception.to_owned());
    }
    let last = last_lines(words, LAST_LINES);
    (!last.is_empty()).then(|| last.join("; "))
}

/// What a program did to end, behind its name, with its last lines of output.
pub(super) fn in_words_of(ended: &Ended, running: &Lockstep) -> String {
    with_last_words(end_in_words(ended), running)
}

fn with_last_words(how: String, running: &Lockstep) -> String {
    let words = running.last_words();
    let said = telling(&words).map(|line| format!("; its last words: {line}"));
    format!("{how}{}", said.unwrap_or_default())
}

fn end_in_words(ended: &Ended) -> String {
    match ended {
        Ended::Exited(status) => Exit::Status(*status).in_words(),
        Ended::NeverWaited { limit } => format!(
            "hung: it ran for {} s of real time without waiting; it computes without end, or waits where virtual time \
             does not reach (docs/virtual-time.md)",
            limit.as_secs_f64()
        ),
        Ended::Deadlocked { .. } => format!("hung: {ended}"),
        other => format!("was stopped: {other}"),
    }
}

/// Port that programs open for a line. Such a file or interface need not exist.
fn port(rig: &Rig, line: usize) -> String {
    match rig.line_name(line) {
        _ if is_serial(rig, line) => format!("/dev/ttyHIL{line}"),
        name if name.len() <= INTERFACE_BYTES_MAX => name.to_owned(),
        _ => format!("hil{line}"),
    }
}

/// The description of a line for a program.
fn place(rig: &Rig, line: usize, name: &str) -> Place {
    let declared = declared(rig, line);
    match declared.map(|line| line.medium) {
        Some(Medium::Serial(settings)) => {
            Place::of_port(format_args!("serial:{name}")).with_settings(settings)
        }
        Some(Medium::Can) | None => {
            let rates = declared.map_or(BitRates::USUAL, RigLine::rates);
            Place::of_port(format_args!("can:{name}")).with_rates(rates)
        }
    }
}

/// The line in the rig file; `None` for a line of the paper's robot, of which nodes can share only the bus.
fn declared(rig: &Rig, line: usize) -> Option<&RigLine> {
    line.checked_sub(rig.robot_lines()).and_then(|line| rig.lines.get(line))
}

fn is_serial(rig: &Rig, line: usize) -> bool {
    declared(rig, line).is_some_and(|line| matches!(line.medium, Medium::Serial(_)))
}

#[derive(Debug)]
struct InStep {
    name: String,
    how: How,
    running: Lockstep,
    uarts: Uarts,
    now: Timestamp,
    /// How far its wall clock is ahead. A clock with a battery goes on while the supply is off.
    ahead: Span,
    /// Why it did not start again.
    not_started: Option<String>,
    /// Its end was reported, or it is off.
    is_told: bool,
    /// The run is over: it does not start again.
    is_over: bool,
}

impl Device for InStep {
    fn receive(&mut self, now: Timestamp, port: PortId, what: &Transmit) {
        self.now = now;
        self.running.receive(now, port, what);
    }

    fn wake(&mut self, now: Timestamp) {
        self.now = now;
        self.running.wake(now);
        self.uarts.look(now, &self.running);
    }

    fn next_wakeup(&self) -> Timestamp {
        // Immediately: its end is to be reported.
        let has_ended = !self.is_told && self.running.ended().is_some();
        let has_news = has_ended || self.not_started.is_some();
        match has_news {
            true => Timestamp::ZERO,
            false => self.running.next_wakeup().min(self.uarts.next_wakeup()),
        }
    }

    fn transmit(&mut self, now: Timestamp) -> Option<(PortId, Transmit)> {
        let sent = self.running.transmit(now);
        self.uarts.look(now, &self.running);
        sent
    }
}

impl NodeDevice for InStep {
    fn ended(&mut self) -> Option<String> {
        if let Some(why) = self.not_started.take() {
            return Some(why);
        }
        let ended = self.running.ended().filter(|_| !self.is_told)?;
        self.is_told = true;
        Some(in_words_of(ended, &self.running))
    }

    fn wrong(&mut self) -> Option<String> {
        self.uarts.wrong(self.now, &self.name, &self.running)
    }

    fn error_frame(&mut self, now: Timestamp, port: PortId, id: u32, data: [u8; 8]) {
        self.now = now;
        self.running.error_frame(now, port, id, data);
    }

    fn set_wall_clock(&mut self, by: Span) -> bool {
        self.ahead += by;
        self.running.set_wall_clock(self.now, by);
        true
    }

    fn power(&mut self, now: Timestamp, on: bool) {
        self.now = now;
        if !on {
            self.running.kill();
            self.is_told = true;
        } else if !self.is_over {
            match self.how.start(true) {
                Ok(running) => {
                    self.running = running;
                    self.running.set_wall_clock(now, self.ahead);
                    self.is_told = false;
                }
                Err(error) => self.not_started = Some(why(&self.name, &error)),
            }
        }
    }

    fn stop(&mut self) -> Option<String> {
        self.is_over = true;
        if self.running.ended().is_some() {
            return None;
        }
        let in_time = self.running.stop(self.now, STOPPING);
        let how = match self.running.ended()? {
            Ended::Stopped(status) if in_time => Exit::Status(*status).when_asked()?,
            Ended::Stopped(_) => killed_after(Duration::from_nanos(STOPPING.as_nanos() as u64)),
            other => format!("was asked to end and {}", end_in_words(other)),
        };
        Some(with_last_words(how, &self.running))
    }

    fn is_given_up(&self) -> bool {
        self.running.ended() == Some(&Ended::GivenUp)
    }
}

/// As on a bench, the program may shut down in order, and is killed if it does not.
impl Drop for InStep {
    fn drop(&mut self) {
        self.running.stop(self.now, STOPPING);
    }
}

#[cfg(test)]
mod tests {
    use super::{Ended, end_in_words, telling};
    use crate::process::Exit;
    use std::os::unix::process::ExitStatusExt as _;
    use std::process::ExitStatus;
    use std::time::Duration;
    use wire::time::{Span, Timestamp};

    #[test]
    fn an_end_in_order_is_no_note() {
        let noted = |raw| Exit::Status(ExitStatus::from_raw(raw)).when_asked();
        for in_order in [0, 143 << 8, 15] {
            assert_eq!(noted(in_order), None);
        }
        let crashed = "was killed by signal 6 (SIGABRT) when it was asked to end";
        assert_eq!(noted(6 | 0x80).as_deref(), Some(crashed));
        assert_eq!(noted(7 << 8).as_deref(), Some("ended with status 7 when it was asked to end"));
    }

    #[test]
    fn what_a_program_did_stands_behind_its_name() {
        let hung = end_in_words(&Ended::NeverWaited { limit: Duration::from_secs(30) });
        assert!(hung.starts_with("hung: it ran for 30 s of real time without waiting"), "{hung}");
        let since = Timestamp::ZERO + Span::from_millis(1_980);
        let stuck = end_in_words(&Ended::Deadlocked { threads: 2, since });
        let named = "hung: all 2 threads of it wait for each other since 1.98 s";
        assert!(stuck.starts_with(named), "{stuck}");
        let others = end_in_words(&Ended::TooManyProcesses { limit: 8 });
        assert_eq!(others, "was stopped: the program started more than 8 processes");
    }

    #[test]
    fn the_lines_that_say_why_are_quoted() {
        let traced = "up\nTraceback (most recent call last):\n  File \"a.py\", line 3, in <module>\n    run()\n\
                      OSError: [Errno 19] No such device\nSocketcanBus was not properly shut down\n";
        assert_eq!(telling(traced).as_deref(), Some("OSError: [Errno 19] No such device"));
        assert_eq!(telling("one\ntwo\n\n").as_deref(), Some("one; two"));
        assert_eq!(telling("1\n2\n3\n4").as_deref(), Some("2; 3; 4"));
        assert_eq!(
            telling("Traceback (most recent call last):\n").as_deref(),
            Some("Traceback (most recent call last):")
        );
        assert_eq!(telling(""), None);
    }
}
