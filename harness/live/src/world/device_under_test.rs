//! The device under test of a live run: our controller in this process, one in its own process, or one that runs
//! already.

use super::clock::Clock;
use super::error::StartError;
use super::heard::Heard;
use super::in_process::{Crossing, InProcess};
use super::ports::{BASE, GYRO, Wiring};
use crate::attached::{AttachError, AttachedDevice, AttachedEvent};
use crate::command::fill;
use crate::process::{DeviceProcess, ProcessEvent, ReportedLine, Unread, log_file};
use controller::config::Config;
use controller::mission::Mission;
use plan::bench_file::AttachPlace;
use ports::PortSpec;
use ports::spec::SerialSpec;
use record::text::name_of;
use rig::node::Machine;
use rig::talk::Talk;
use std::fmt;
use std::path::{Path, PathBuf};
use wire::time::{Span, Timestamp};

#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DeviceUnderTest {
    /// Our controller, in this process, on the same ports that a process would open.
    InProcess,
    /// Our controller, in its own process.
    OurProcess,
    /// Any program: its command line, with `{gyro}` and `{base}` for the ports.
    Command(Vec<String>),
    /// A device started by the user, which takes its missions at this place.
    Attached(AttachPlace),
    /// A device, by name, real or emulated, to which the plan itself talks.
    Device(String),
    /// Only the [programs](super::Program) of nodes.
    Nodes,
}

/// Name for a summary.
impl fmt::Display for DeviceUnderTest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::InProcess => f.write_str("in-process"),
            Self::OurProcess => f.write_str("process"),
            Self::Command(words) => f.write_str(&words.join(" ")),
            Self::Attached(place) => write!(f, "attached at {place}"),
            Self::Device(name) => f.write_str(name),
            Self::Nodes => Ok(()),
        }
    }
}

#[derive(Debug)]
pub(super) enum Running {
    InProcess(Box<InProcess>),
    Process {
        process: Box<DeviceProcess>,
        /// Its end was reported; it is not polled again.
        ended: bool,
    },
    Attached {
        device: Box<AttachedDevice>,
        place: AttachPlace,
        /// Why it is not connected; `None` while connected.
        missing: Option<String>,
    },
    /// A device at a port of the harness, or programs of nodes: no controller is started.
    Device,
}

impl Running {
    pub(super) async fn start(
        which: &DeviceUnderTest,
        (config, with_faults): (Option<Config>, bool),
        wiring: &Wiring,
        log: &Path,
    ) -> Result<Self, StartError> {
        let Some(config) = config else { return Ok(Self::Device) };
        let words = match which {
            DeviceUnderTest::InProcess => {
                let started = InProcess::start(config, with_faults, wiring).await?;
                return Ok(Self::InProcess(Box::new(started)));
            }
            DeviceUnderTest::OurProcess => {
                for (role, needed, known) in [
                    (GYRO, true, wiring.port(GYRO).is_some()),
                    (BASE, config.base.is_some(), wiring.port(BASE).is_some()),
                ] {
                    if needed && !known {
                        return Err(StartError::NoFarSide { role });
                    }
                }
                our_command(&config, wiring)
            }
            DeviceUnderTest::Command(words) => words.clone(),
            DeviceUnderTest::Attached(place) => return Ok(Self::attach(place, wiring)?),
            DeviceUnderTest::Device(_) | DeviceUnderTest::Nodes => return Ok(Self::Device),
        };
        let words = fill(&words, &wiring.words)?;
        let process = DeviceProcess::spawn(&words, &wiring.places, log_file(log, false)?, true)?;
        Ok(Self::Process { process: Box::new(process), ended: false })
    }

    /// Begins to connect, and logs the ports: the user may have to start the controller.
    fn attach(place: &AttachPlace, wiring: &Wiring) -> Result<Self, AttachError> {
        let device = AttachedDevice::begin(place)?;
        let ports = wiring.words.iter().map(|(role, port)| format!("{role} at {port}, "));
        let ports: String = ports.collect();
        let missions = match device.far_path() {
            Some(path) => path.to_owned(),
            None => place.to_string(),
        };
        tracing::warn!("waiting for the device under test: {ports}missions at {missions}");
        let missing = Some("nobody has connected".to_owned());
        Ok(Self::Attached { device: Box::new(device), place: place.clone(), missing })
    }

    /// A message why it has not reported a state in all this time, and what it has said instead.
    pub(super) fn why_silent(&self, waited: Span, talk: &Talk) -> String {
        let why = talk.why_silent(waited);
        match self {
            Self::Attached { place, missing: Some(why), .. } => {
                format!("no device under test at {place} within {} s: {why}", waited.as_secs_f64())
            }
            Self::Attached { place, missing: None, .. } => {
                format!("the device under test at {place} {why}")
            }
            Self::InProcess(_) | Self::Process { .. } | Self::Device => {
                format!("the device under test {why}{}", self.last_words())
            }
        }
    }

    /// Whether nobody has connected who could say anything.
    pub(super) const fn is_missing(&self) -> bool {
        matches!(self, Self::Attached { missing: Some(_), .. })
    }

    pub(super) fn command(&mut self, clock: &Clock, mission: Mission) -> bool {
        match self {
            Self::InProcess(controller) => {
                controller.command(clock, mission);
                true
            }
            Self::Device => false,
            Self::Process { process, .. } => process.send(&mission),
            Self::Attached { device, .. } => device.send(&mission),
        }
    }

    pub(super) fn wake(&mut self, clock: &Clock, now: Timestamp) {
        if let Self::InProcess(controller) = self {
            controller.wake(clock, now);
        }
    }

    /// Notifies an in-process controller that a fault struck its machine.
    pub(super) fn struck(&mut self, clock: &Clock, now: Timestamp) {
        if let Self::InProcess(controller) = self {
            controller.struck(clock, now);
        }
    }

    pub(super) const fn machine(&mut self) -> Option<&mut Machine> {
        if let Self::InProcess(controller) = self { Some(controller.machine()) } else { None }
    }

    pub(super) fn next_wakeup(&self) -> Timestamp {
        self.in_process().map_or(Timestamp::MAX, InProcess::next_wakeup)
    }

    /// Process id, if the harness started a process.
    pub(super) fn process(&self) -> Option<u32> {
        if let Self::Process { process, .. } = self { process.id() } else { None }
    }

    pub(super) const fn in_process(&self) -> Option<&InProcess> {
        if let Self::InProcess(controller) = self { Some(controller) } else { None }
    }

    /// Returns what has crossed the ports of an in-process controller, oldest first.
    pub(super) fn crossing(&mut self) -> Option<Crossing> {
        if let Self::InProcess(controller) = self { controller.crossing() } else { None }
    }

    /// The end of the process's stderr, as the end of a sentence.
    fn last_words(&self) -> String {
        if let Self::Process { process, .. } = self { quoted(process) } else { String::new() }
    }

    /// Waits for the next event. Cancel-safe.
    pub(super) async fn heard(&mut self, clock: &Clock) -> Heard {
        match self {
            Self::Device => std::future::pending().await,
            Self::InProcess(controller) => controller.heard(clock).await,
            Self::Process { ended: true, .. } => std::future::pending().await,
            Self::Process { process, ended } => match process.next_event().await {
                ProcessEvent::Line(line) => of_line(line),
                ProcessEvent::Exited(exit) => {
                    *ended = true;
                    Heard::Ended(format!("{}{}", exit.in_words(), quoted(process)))
                }
            },
            Self::Attached { device, place, missing } => match device.next_event().await {
                AttachedEvent::Line(line) => of_line(line),
                AttachedEvent::NotThere(why) => {
                    *missing = Some(why);
                    Heard::Nothing
                }
                AttachedEvent::Connected => {
                    *missing = None;
                    Heard::Note(format!("attached to the device under test at {place}"))
                }
                AttachedEvent::Ended(why) => Heard::Ended(format!("at {place} is gone: {why}")),
                AttachedEvent::Lost(why) => Heard::Lost(format!("lost {place}: {why}")),
            },
        }
    }

    pub(super) async fn end(self) {
        match self {
            Self::InProcess(_) | Self::Device => {}
            Self::Process { process, .. } => _ = process.end(|_| {}).await,
            Self::Attached { device, .. } => device.end().await,
        }
    }
}

/// The end of a process's stderr, as the end of a sentence.
pub(super) fn quoted(process: &DeviceProcess) -> String {
    match process.last_words().trim() {
        "" => String::new(),
        words => format!(": {words}"),
    }
}

fn of_line(line: ReportedLine) -> Heard {
    let (number, Unread { cause, is_grave }) = match line {
        ReportedLine::Report(line) => return Heard::Report(line.report),
        ReportedLine::Bad { number, unread } => (number, unread),
    };
    let what = format!("line {number} of the device under test: {cause}");
    if is_grave { Heard::Misreport(what) } else { Heard::BadLine(what) }
}

fn our_command(config: &Config, wiring: &Wiring) -> Vec<String> {
    let base = match wiring.port(BASE) {
        None => "none".to_owned(),
        Some(PortSpec::Can { .. }) => "can:{base}".to_owned(),
        Some(PortSpec::Slcan { .. } | PortSpec::SlcanPty { .. }) => "slcan:{base}".to_owned(),
        Some(spec @ (PortSpec::Serial(_) | PortSpec::Pty { .. })) => {
            format!("serial:{{base}}{}", rate(spec))
        }
    };
    let gyro = format!("{{gyro}}{}", wiring.port(GYRO).map(rate).unwrap_or_default());
    controller_words(config, &gyro, &base)
}

/// Command line of our controller, with the ports of its gyro and its base.
pub fn controller_words(config: &Config, gyro: &str, base: &str) -> Vec<String> {
    let stream = config.gyro.stream;
    let mut words: Vec<String> = vec![
        our_program().to_string_lossy().into_owned(),
        "--gyro".to_owned(),
        gyro.to_owned(),
        "--stream".to_owned(),
        name_of(&stream.format),
        "--mode".to_owned(),
        name_of(&stream.mode),
        "--base".to_owned(),
        base.to_owned(),
    ];
    if stream.reversed {
        words.push("--reversed".to_owned());
    }
    words
}

/// The rate of a port, if given, in our controller's syntax.
fn rate(spec: &PortSpec) -> String {
    match spec {
        PortSpec::Serial(SerialSpec { options, .. }) => {
            options.baud.map(|baud| format!(":{baud}")).unwrap_or_default()
        }
        _ => String::new(),
    }
}

/// Path of our controller: beside this program, where a build puts it; else its name, to be found in PATH.
pub fn our_program() -> PathBuf {
    let name = "k2a-controller";
    std::env::current_exe()
        .ok()
        .and_then(|path| {
            let folder = path.parent()?;
            // The program of a test is one folder deeper.
            [folder, folder.parent()?]
                .map(|folder| folder.join(name))
                .into_iter()
                .find(|p| p.is_file())
        })
        .unwrap_or_else(|| PathBuf::from(name))
}
