//! The device under test of a live run: our controller in this process, or a process of its own.

use super::clock::Clock;
use super::in_process::{Crossed, InProcess, InProcessEvent};
use super::placement::{Placement, Player};
use super::ports::{BASE, GYRO, Wiring};
use super::role_port::PortEvent;
use crate::live::command::{CommandError, fill};
use crate::live::process::{DeviceProcess, ProcessEvent, SpawnError};
use crate::port::spec::SerialSpec;
use crate::port::{PortError, PortSpec};
use crate::record::Device;
use controller::config::Config;
use controller::mission::{Mission, Report};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use wire::time::Timestamp;

/// Which device is tested.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DeviceUnderTest {
    /// Our controller, in this process, on the same ports that a process would open.
    InProcess,
    /// Our controller, as a process of its own.
    OurProcess,
    /// Anybody's program: its command line, with `{gyro}` and `{base}` for the ports.
    Command(Vec<String>),
}

/// Why the device under test does not start.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum StartError {
    /// Its command line is not right.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Command(#[from] CommandError),
    /// It does not start.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Spawn(#[from] SpawnError),
    /// A port cannot be opened.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Port(#[from] PortError),
    /// The emulated device is on a port whose other end is out of sight.
    #[error("failed to find the other end of the {role}'s port, which the controller should open")]
    #[diagnostic(help(
        "give the command line of a controller that knows its port: [controller] command = \
         [\"./program\", \"--{role}\", \"/dev/ttyUSB1\"]"
    ))]
    NoFarSide {
        /// The role.
        role: &'static str,
    },
}

/// What came from the device under test.
pub(super) enum Heard {
    /// A report.
    Report(Report),
    /// Bytes or frames were taken in; a report may follow.
    Nothing,
    /// A line that is no report.
    BadLine(String),
    /// A port of the controller in the process tells of itself.
    Port(&'static str, PortEvent),
    /// It has ended.
    Ended(String),
}

/// A device under test that runs.
#[derive(Debug)]
pub(super) enum Running {
    InProcess(Box<InProcess>),
    Process {
        process: Box<DeviceProcess>,
        /// It has told that it ended, and is not asked again.
        ended: bool,
    },
}

impl Running {
    pub(super) async fn start(
        which: &DeviceUnderTest,
        config: Config,
        placement: &Placement,
        wiring: &Wiring,
        log: &Path,
    ) -> Result<Self, StartError> {
        let words = match which {
            DeviceUnderTest::InProcess => {
                let unheard = unheard(placement);
                let started = InProcess::start(config, wiring, unheard).await?;
                return Ok(Self::InProcess(Box::new(started)));
            }
            DeviceUnderTest::OurProcess => {
                for (role, needed, known) in [
                    (GYRO, true, wiring.gyro.is_some()),
                    (BASE, config.base.is_some(), wiring.base.is_some()),
                ] {
                    if needed && !known {
                        return Err(StartError::NoFarSide { role });
                    }
                }
                our_command(&config, wiring)
            }
            DeviceUnderTest::Command(words) => words.clone(),
        };
        let process = DeviceProcess::spawn(&fill(&words, &wiring.words)?, log)?;
        Ok(Self::Process { process: Box::new(process), ended: false })
    }

    pub(super) fn command(&mut self, clock: &Clock, mission: Mission) -> bool {
        match self {
            Self::InProcess(controller) => {
                controller.command(clock, mission);
                true
            }
            Self::Process { process, .. } => process.send(&mission),
        }
    }

    pub(super) fn wake(&mut self, clock: &Clock, now: Timestamp) {
        if let Self::InProcess(controller) = self {
            controller.wake(clock, now);
        }
    }

    pub(super) fn next_wakeup(&self) -> Timestamp {
        match self {
            Self::InProcess(controller) => controller.next_wakeup(),
            Self::Process { .. } => Timestamp::MAX,
        }
    }

    /// The controller, where it is in this process.
    pub(super) const fn in_process(&self) -> Option<&InProcess> {
        match self {
            Self::InProcess(controller) => Some(controller),
            Self::Process { .. } => None,
        }
    }

    /// What has crossed a port that nobody else hears, oldest first.
    pub(super) fn crossing(&mut self) -> Option<(Device, Crossed)> {
        match self {
            Self::InProcess(controller) => controller.crossing(),
            Self::Process { .. } => None,
        }
    }

    /// The end of what the process wrote to stderr, as an ending of a sentence.
    pub(super) fn last_words(&self) -> String {
        match self {
            Self::InProcess(_) => String::new(),
            Self::Process { process, .. } => match process.last_words().trim() {
                "" => String::new(),
                words => format!(": {words}"),
            },
        }
    }

    /// Waits for what comes next. May be called off without losing anything.
    pub(super) async fn heard(&mut self, clock: &Clock) -> Heard {
        match self {
            Self::InProcess(controller) => match controller.heard(clock).await {
                InProcessEvent::Report(report) => Heard::Report(report),
                InProcessEvent::Taken => Heard::Nothing,
                InProcessEvent::Port(role, event) => Heard::Port(role, event),
            },
            Self::Process { ended: true, .. } => std::future::pending().await,
            Self::Process { process, ended } => match process.next_event().await {
                ProcessEvent::Report(line) => Heard::Report(line.report),
                ProcessEvent::BadLine { number, cause } => {
                    Heard::BadLine(format!("line {number} of the device under test: {cause}"))
                }
                ProcessEvent::Exited(exit) => {
                    *ended = true;
                    let words = process.last_words();
                    Heard::Ended(match words.trim() {
                        "" => exit.to_string(),
                        words => format!("{exit}: {words}"),
                    })
                }
            },
        }
    }

    pub(super) async fn end(self) {
        if let Self::Process { process, .. } = self {
            process.end(|_| {}).await;
        }
    }
}

/// Real devices that the controller alone talks to. A bus of the kernel is heard by the harness, too.
fn unheard(placement: &Placement) -> BTreeSet<&'static str> {
    let players = [(GYRO, Some(&placement.gyro)), (BASE, placement.base.as_ref())];
    let unheard = players.into_iter().filter(|(_, player)| {
        matches!(player, Some(Player::Real(spec)) if !matches!(spec, PortSpec::Can { .. }))
    });
    unheard.map(|(role, _)| role).collect()
}

/// The command line of our controller for this bench.
fn our_command(config: &Config, wiring: &Wiring) -> Vec<String> {
    let stream = config.gyro.stream;
    let base = match &wiring.base {
        None => "none".to_owned(),
        Some(PortSpec::Can { .. }) => "can:{base}".to_owned(),
        Some(PortSpec::Slcan { .. } | PortSpec::SlcanPty { .. }) => "slcan:{base}".to_owned(),
        Some(spec @ (PortSpec::Serial(_) | PortSpec::Pty { .. })) => {
            format!("serial:{{base}}{}", rate(spec))
        }
    };
    let gyro = format!("{{gyro}}{}", wiring.gyro.as_ref().map(rate).unwrap_or_default());
    let mut words: Vec<String> = vec![
        our_program().to_string_lossy().into_owned(),
        "--gyro".to_owned(),
        gyro,
        "--stream".to_owned(),
        word(&stream.format),
        "--mode".to_owned(),
        word(&stream.mode),
        "--base".to_owned(),
        base,
    ];
    if stream.reversed {
        words.push("--reversed".to_owned());
    }
    words
}

/// The rate of a port that says one, as our controller takes it.
fn rate(spec: &PortSpec) -> String {
    match spec {
        PortSpec::Serial(SerialSpec { options, .. }) => {
            options.baud.map(|baud| format!(":{baud}")).unwrap_or_default()
        }
        _ => String::new(),
    }
}

/// Beside this program, where a build puts it; else wherever PATH has it.
pub(crate) fn our_program() -> PathBuf {
    let name = "k2a-controller";
    std::env::current_exe()
        .ok()
        .and_then(|path| {
            let folder = path.parent()?;
            // A test's program lies one folder deeper.
            [folder, folder.parent()?]
                .map(|folder| folder.join(name))
                .into_iter()
                .find(|p| p.is_file())
        })
        .unwrap_or_else(|| PathBuf::from(name))
}

/// An enumerator as it is written in files and on command lines.
fn word(value: &impl serde::Serialize) -> String {
    serde_json::to_value(value)
        .ok()
        .and_then(|value| value.as_str().map(str::to_owned))
        .unwrap_or_default()
}
