//! The shell around emulated devices: the real clock, ports, requests, signals.

use super::build::Setup;
use super::control::{Asked, Control, ControlError};
use super::emulated::Emulated;
pub use super::outlet::LINES_MAX;
use super::outlet::Outlet;
use super::request;
use crate::lines;
use crate::world::ports::{OpenPort, Ports};
use crate::world::role_port::PortEvent;
use crate::world::{Alarm, Clock};
use ports::{PortError, PortSpec};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::time::Duration;
use tokio::signal::unix::{Signal, SignalKind, signal};
use wire::device::Transmit;
use wire::time::{Span, Timestamp};

/// How often the rates are looked at that programs set at the ptys.
const RATES_LOOKED_AT_EVERY: Duration = Duration::from_secs(1);

/// Why devices cannot be emulated, or not any longer.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum EmulationError {
    /// A port cannot be opened, or was lost for good.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Port(#[from] PortError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Control(#[from] ControlError),
    /// The event loop or the signal handlers could not be started.
    #[error("failed to start the event loop")]
    Runtime(#[source] io::Error),
    #[error("failed to write to the standard output")]
    Output(#[source] io::Error),
    #[error("failed to emulate {0}")]
    Device(String),
}

/// Emulates devices until SIGINT or SIGTERM. Writes JSON lines to `out`: one for each port when all are open, the
/// answers to requests on the standard input, and the counters at the end. A slow reader blocks nothing: beyond
/// [`LINES_MAX`] lines answers are dropped. `warn` gets a line for that, for ports that are lost or come back, and
/// for a wrong rate at the other end of a pty.
///
/// # Errors
/// When a port cannot be opened or is lost for good, or `out` is closed.
pub fn run(
    setup: &Setup,
    out: impl Write + Send + 'static,
    warn: &mut impl FnMut(&str),
) -> Result<(), EmulationError> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(EmulationError::Runtime)?;
    runtime.block_on(run_in_runtime(setup, out, warn))
}

async fn run_in_runtime(
    setup: &Setup,
    out: impl Write + Send + 'static,
    warn: &mut impl FnMut(&str),
) -> Result<(), EmulationError> {
    let mut stop = Stop::install().map_err(EmulationError::Runtime)?;
    let (mut emulated, plans) = Emulated::new(setup);
    let mut ports = Ports::open(plans).await?;
    let mut control = Control::open(setup.control.as_deref())?;
    let mut out = Outlet::spawn(out).map_err(EmulationError::Output)?;
    let _told = lines::Kept::or_warn(&ports.wiring()?.places);
    let clock = Clock::start();
    let alarm = Alarm::new(clock).map_err(EmulationError::Runtime)?;
    for port in &ports.open {
        out.say(ready(port).to_string());
    }

    let mut late_max = Span::ZERO;
    let mut look = tokio::time::interval(RATES_LOOKED_AT_EVERY);
    let mut wrong = None;
    loop {
        let now = clock.now();
        emulated.wake(now);
        if let Some(why) = emulated.failure.take() {
            return Err(EmulationError::Device(why));
        }
        while let Some((line, from, what)) = emulated.transmit() {
            let elsewhere = ports.of_line(line).filter(|open| open.plan.end != from);
            elsewhere.for_each(|open| open.send(now, &what));
        }
        let due = emulated.next_wakeup();
        tokio::select! {
            rung = alarm.at(due) => {
                rung.map_err(EmulationError::Runtime)?;
                late_max = late_max.max(clock.now() - due);
            }
            (place, event) = ports.next() => {
                let OpenPort { plan, port, .. } = &ports.open[place];
                let what = format!("the {} on {}", plan.role, port.name());
                let at = (plan.line, plan.end);
                match event {
                    PortEvent::Bytes(bytes) => {
                        emulated.receive(clock.now(), at, Transmit::Bytes(bytes));
                    }
                    PortEvent::Frame(frame) => {
                        emulated.receive(clock.now(), at, Transmit::Frame(frame));
                    }
                    PortEvent::Lost(lost) => warn(&format!("lost {what}: {lost}")),
                    PortEvent::Back => warn(&format!("{what} is back")),
                    PortEvent::Away(error) => return Err(error.into()),
                    PortEvent::Break | PortEvent::Bus(_) | PortEvent::Down | PortEvent::Up
                    | PortEvent::Opened | PortEvent::Closed => {}
                }
            }
            _ = look.tick() => {
                let found = ports.wrong_rate(clock.now());
                if let Some(why) = found.as_ref().filter(|_| found != wrong) {
                    warn(why);
                }
                wrong = found;
            }
            asked = control.next() => {
                let (id, request) = request::read(&asked.line);
                let told = request.and_then(|request| emulated.request(clock.now(), &request));
                if !reply(asked, request::answer(id, told), &mut out) {
                    warn("nobody reads the standard output: answers are dropped");
                }
            }
            error = out.broken() => return Err(EmulationError::Output(error)),
            () = stop.requested() => break,
        }
    }
    let counted = ports.open.iter().map(|open| (open.plan.role.to_string(), open.counted()));
    let ended = json!({ "ended": {
        "after_s": (clock.now() - Timestamp::ZERO).as_secs_f64(),
        "late_ms_max": late_max.as_secs_f64() * 1e3,
        "ports": counted.collect::<BTreeMap<_, _>>(),
        "counters": emulated.counters(),
        "answers_dropped": out.dropped(),
    }});
    out.say(ended.to_string());
    out.finish().await.map_err(EmulationError::Output)
}

/// What another program needs to use a port: `ready`, `port`, and `link` if there is one.
fn ready(open: &OpenPort) -> Value {
    let spec = &open.plan.spec;
    let link = match spec {
        PortSpec::Pty { link } | PortSpec::SlcanPty { link } => link.as_ref(),
        _ => None,
    };
    let target = link.and_then(|link| std::fs::read_link(link).ok());
    let target = target.map(|target| target.to_string_lossy().into_owned());
    let named = target.or_else(|| open.port.far_path().map(str::to_owned));
    let mut told = Map::new();
    told.insert("ready".to_owned(), json!(&*open.plan.role));
    told.insert("port".to_owned(), json!(named.unwrap_or_else(|| spec.to_string())));
    if let Some(link) = link {
        told.insert("link".to_owned(), json!(link.to_string_lossy()));
    }
    Value::Object(told)
}

/// Sends an answer to the client; returns `false` for the first one that finds no room on the standard output.
fn reply(asked: Asked, answered: String, out: &mut Outlet) -> bool {
    match asked.client {
        // A client that has left misses its answer; others are not affected.
        Some(client) => {
            let _ = client.send(answered);
            true
        }
        None => out.say(answered),
    }
}

/// SIGINT and SIGTERM.
struct Stop {
    interrupt: Signal,
    terminate: Signal,
}

impl Stop {
    fn install() -> io::Result<Self> {
        Ok(Self {
            interrupt: signal(SignalKind::interrupt())?,
            terminate: signal(SignalKind::terminate())?,
        })
    }

    async fn requested(&mut self) {
        tokio::select! {
            _ = self.interrupt.recv() => {}
            _ = self.terminate.recv() => {}
        }
    }
}
