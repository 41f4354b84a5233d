//! The device under test of a live run: our controller in this process, or a process of its own.

use super::Clock;
use crate::live::command::{CommandError, fill};
use crate::live::process::{DeviceProcess, ProcessEvent, SpawnError};
use controller::config::{Config, Transport};
use controller::mission::{Mission, Report};
use controller::{Controller, Input, Output, Port};
use rustix::fs::{Mode, OFlags};
use std::collections::BTreeMap;
use std::io;
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use tokio::io::unix::AsyncFd;
use wire::packet::BYTES_MAX;
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
    #[error("failed to open the port {port}: {source}")]
    #[diagnostic(help("is it spelt right, plugged in, and yours to open (group dialout)?"))]
    Port {
        /// The port.
        port: String,
        /// Why.
        source: io::Error,
    },
}

/// What came from the device under test.
pub(super) enum Heard {
    /// A report.
    Report(Report),
    /// Bytes were taken in; a report may follow.
    Nothing,
    /// A line that is no report.
    BadLine(String),
    /// It has ended.
    Ended(String),
}

/// A device under test that runs.
#[derive(Debug)]
pub(super) enum Running {
    InProcess {
        controller: Box<Controller>,
        gyro: AsyncFd<OwnedFd>,
        base: Option<AsyncFd<OwnedFd>>,
    },
    Process {
        process: Box<DeviceProcess>,
        /// It has told that it ended, and is not asked again.
        ended: bool,
    },
}

impl Running {
    pub(super) fn start(
        which: &DeviceUnderTest,
        config: Config,
        ports: &BTreeMap<String, String>,
        log: &Path,
    ) -> Result<Self, StartError> {
        let words = match which {
            DeviceUnderTest::InProcess => {
                let port = |role: &str| ports.get(role).map(|port| open(port)).transpose();
                let missing = || StartError::Port {
                    port: super::GYRO.to_owned(),
                    source: io::ErrorKind::NotFound.into(),
                };
                return Ok(Self::InProcess {
                    controller: Box::new(Controller::new(config, Timestamp::ZERO)),
                    gyro: port(super::GYRO)?.ok_or_else(missing)?,
                    base: port(super::BASE)?,
                });
            }
            DeviceUnderTest::OurProcess => our_command(&config),
            DeviceUnderTest::Command(words) => words.clone(),
        };
        let process = DeviceProcess::spawn(&fill(&words, ports)?, log)?;
        Ok(Self::Process { process: Box::new(process), ended: false })
    }

    pub(super) fn command(&mut self, now: Timestamp, mission: Mission) -> bool {
        match self {
            Self::InProcess { controller, gyro, base } => {
                controller.command(now, mission);
                send(controller, now, gyro, base.as_ref());
                true
            }
            Self::Process { process, .. } => process.send(&mission),
        }
    }

    pub(super) fn wake(&mut self, now: Timestamp) {
        if let Self::InProcess { controller, gyro, base } = self
            && controller.next_wakeup() <= now
        {
            controller.wake(now);
            send(controller, now, gyro, base.as_ref());
        }
    }

    pub(super) fn next_wakeup(&self) -> Timestamp {
        match self {
            Self::InProcess { controller, .. } => controller.next_wakeup(),
            Self::Process { .. } => Timestamp::MAX,
        }
    }

    /// The end of what the process wrote to stderr, as an ending of a sentence.
    pub(super) fn last_words(&self) -> String {
        match self {
            Self::InProcess { .. } => String::new(),
            Self::Process { process, .. } => match process.last_words().trim() {
                "" => String::new(),
                words => format!(": {words}"),
            },
        }
    }

    /// Waits for what comes next. May be called off without losing anything.
    pub(super) async fn heard(&mut self, clock: &Clock) -> Heard {
        match self {
            Self::InProcess { controller, gyro, base } => {
                if let Some(report) = controller.report() {
                    return Heard::Report(report);
                }
                let (mut from_gyro, mut from_base) = ([0; BYTES_MAX], [0; BYTES_MAX]);
                let (port, bytes) = tokio::select! {
                    count = read(Some(gyro), &mut from_gyro) => (Port::Gyro, &from_gyro[..count]),
                    count = read(base.as_ref(), &mut from_base) => (Port::Base, &from_base[..count]),
                };
                let now = clock.now();
                controller.receive(now, port, Input::Bytes(bytes));
                send(controller, now, gyro, base.as_ref());
                Heard::Nothing
            }
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

/// The command line of our controller for this bench.
fn our_command(config: &Config) -> Vec<String> {
    let stream = config.gyro.stream;
    let base = match config.base.map(|base| base.transport) {
        None => "none",
        Some(Transport::Serial) => "serial:{base}",
        Some(Transport::Can) => "can:{base}",
    };
    let mut words: Vec<String> = vec![
        our_program().to_string_lossy().into_owned(),
        "--gyro".to_owned(),
        "{gyro}".to_owned(),
        "--stream".to_owned(),
        word(&stream.format),
        "--mode".to_owned(),
        word(&stream.mode),
        "--base".to_owned(),
        base.to_owned(),
    ];
    if stream.reversed {
        words.push("--reversed".to_owned());
    }
    words
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

fn open(port: &str) -> Result<AsyncFd<OwnedFd>, StartError> {
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
    rustix::fs::open(port, flags, Mode::empty())
        .map_err(io::Error::from)
        .and_then(watch)
        .map_err(|source| StartError::Port { port: port.to_owned(), source })
}

#[expect(deprecated, reason = "its successor is unsafe; an OwnedFd keeps what that asks for")]
fn watch(port: OwnedFd) -> io::Result<AsyncFd<OwnedFd>> {
    AsyncFd::new(port)
}

async fn read(port: Option<&AsyncFd<OwnedFd>>, buffer: &mut [u8; BYTES_MAX]) -> usize {
    let Some(port) = port else { return std::future::pending().await };
    port.async_io(tokio::io::Interest::READABLE, |port| Ok(rustix::io::read(port, &mut *buffer)?))
        .await
        .unwrap_or(0)
}

/// Writes what the controller has to send. What finds no room on the line is lost, as on a UART.
fn send(
    controller: &mut Controller,
    now: Timestamp,
    gyro: &AsyncFd<OwnedFd>,
    base: Option<&AsyncFd<OwnedFd>>,
) {
    while let Some(output) = controller.transmit(now) {
        if let Output::Bytes(port, packet) = output {
            let port = match port {
                Port::Gyro => Some(gyro),
                Port::Base => base,
            };
            if let Some(port) = port {
                let _ = rustix::io::write(port.get_ref(), packet.as_slice());
            }
        }
    }
}
