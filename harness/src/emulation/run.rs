//! The shell around emulated devices: the real clock, ports, requests, signals.

use super::bench::{EmulatedBench, Parts};
use super::control::{Asked, Control, ControlError};
use super::link::Pace;
use super::ports::{Crosses, Heard, RolePort, RolePorts, pace};
use super::request;
use super::{Role, tell};
use crate::port::{PortError, PortSpec};
use crate::world::live::Clock;
use serde_json::json;
use std::collections::BTreeMap;
use std::io;
use std::path::PathBuf;
use tokio::signal::unix::{Signal, SignalKind, signal};
use wire::serial::SerialSettings;
use wire::time::{Span, Timestamp};

/// What is emulated, and where.
#[derive(Debug, Clone)]
pub struct Setup {
    /// The devices.
    pub parts: Parts,
    /// Their ports; a device without one is there, and nobody talks to it.
    pub ports: BTreeMap<Role, PortSpec>,
    /// A socket for requests, besides the standard input.
    pub control: Option<PathBuf>,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// Why devices are not, or no longer, emulated.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum EmulationError {
    /// A port cannot be opened, or was lost for good.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Port(#[from] PortError),
    /// Nobody could ask for anything.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Control(#[from] ControlError),
    /// No event loop, or no signals.
    #[error("failed to start the event loop")]
    Runtime(#[source] io::Error),
    /// Nobody would hear what is ready and what is answered.
    #[error("failed to write to the standard output")]
    Output(#[source] io::Error),
}

/// Emulates devices until SIGINT or SIGTERM. Each line of JSON goes to `say`: one for each port when all
/// are open, the answers to requests on the standard input, and the counters at the end. `warn` is told
/// of ports that are lost or come back.
///
/// # Errors
/// When a port cannot be opened or is lost for good, or `say` fails.
pub fn run(
    setup: &Setup,
    say: &mut impl FnMut(&str) -> io::Result<()>,
    warn: &mut impl FnMut(&str),
) -> Result<(), EmulationError> {
    in_runtime(run_in_runtime(setup, say, warn))
}

/// Carries out what waits for ports and clocks.
pub(super) fn in_runtime(
    emulation: impl Future<Output = Result<(), EmulationError>>,
) -> Result<(), EmulationError> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(EmulationError::Runtime)?;
    runtime.block_on(emulation)
}

async fn run_in_runtime(
    setup: &Setup,
    say: &mut impl FnMut(&str) -> io::Result<()>,
    warn: &mut impl FnMut(&str),
) -> Result<(), EmulationError> {
    let mut stop = Stop::install().map_err(EmulationError::Runtime)?;
    let mut opened = Vec::new();
    for (role, spec) in &setup.ports {
        let crosses = match role {
            Role::Base if spec.carries_frames() => Crosses::Frames,
            role => Crosses::Bytes(settings(&setup.parts, *role)),
        };
        opened.push((*role, RolePort::open(role.name(), spec, crosses).await?));
    }
    let mut ports = RolePorts::new(opened);
    let mut control = Control::open(setup.control.as_deref())?;
    let clock = Clock::start();
    let mut bench = EmulatedBench::new(setup.parts.clone(), &paces(setup), setup.seed);
    for port in ports.iter() {
        say(&port.ready().to_string()).map_err(EmulationError::Output)?;
    }

    let mut late_max = Span::ZERO;
    loop {
        let now = clock.now();
        bench.wake(now);
        while let Some((role, output)) = bench.transmit() {
            ports.send(now, role, &output);
        }
        let due = bench.next_wakeup();
        tokio::select! {
            () = clock.sleep_until(due) => late_max = late_max.max(clock.now() - due),
            (role, heard) = ports.hear() => match heard {
                Heard::Input(input) => bench.receive(clock.now(), role, input),
                Heard::Nothing => {}
                Heard::Changed(what) => warn(&what),
                Heard::GivenUp(error) => return Err(error.into()),
            },
            asked = control.next() => {
                let answered = answer(&mut bench, clock.now(), &asked.line);
                reply(asked, answered, say)?;
            }
            () = stop.requested() => break,
        }
    }
    let ended = json!({ "ended": {
        "after_s": (clock.now() - Timestamp::ZERO).as_secs_f64(),
        "late_ms_max": late_max.as_secs_f64() * 1e3,
        "ports": ports.counters(),
        "counters": tell::counters(&bench),
    }});
    say(&ended.to_string()).map_err(EmulationError::Output)
}

/// The settings of a device's line.
fn settings(parts: &Parts, role: Role) -> SerialSettings {
    match (role, &parts.gyro) {
        (Role::Gyro, Some((stream, _))) => stream.format.serial(),
        (Role::Gyro, None) | (Role::Base, _) => wire::base::serial_link::SETTINGS,
        (Role::Table, _) => wire::table::SETTINGS,
    }
}

fn paces(setup: &Setup) -> BTreeMap<Role, Pace> {
    let pace =
        |(role, spec): (&Role, &PortSpec)| (*role, pace(spec, settings(&setup.parts, *role)));
    setup.ports.iter().map(pace).collect()
}

fn answer(bench: &mut EmulatedBench, now: Timestamp, line: &[u8]) -> String {
    let (id, request) = request::read(line);
    request::answer(id, request.and_then(|request| bench.request(now, &request)))
}

pub(super) fn reply(
    asked: Asked,
    answered: String,
    say: &mut impl FnMut(&str) -> io::Result<()>,
) -> Result<(), EmulationError> {
    match asked.client {
        // A client that has left misses its answer, and nobody else does.
        Some(client) => {
            let _ = client.send(answered);
            Ok(())
        }
        None => say(&answered).map_err(EmulationError::Output),
    }
}

/// SIGINT and SIGTERM.
pub(super) struct Stop {
    interrupt: Signal,
    terminate: Signal,
}

impl Stop {
    pub(super) fn install() -> io::Result<Self> {
        Ok(Self {
            interrupt: signal(SignalKind::interrupt())?,
            terminate: signal(SignalKind::terminate())?,
        })
    }

    pub(super) async fn requested(&mut self) {
        tokio::select! {
            _ = self.interrupt.recv() => {}
            _ = self.terminate.recv() => {}
        }
    }
}
