//! `k2a-controller`: the [`controller`] library on real ports and the real clock.
//!
//! Missions arrive as JSON lines on stdin or a socket; reports leave as JSON lines on stdout or the same socket
//! ([`controller::mission`] documents both). The log goes to stderr. The process ends when stdin or stdout closes, on a
//! signal, or when a port is lost for good. Before it ends, it brings the base to rest.

mod arguments;
mod listen;
mod log;
mod orders;
mod outlet;
mod port;
mod shell;
mod signals;

use arguments::{Arguments, Setup};
use clap::{CommandFactory as _, Parser as _, error::ErrorKind};
use controller::{Controller, Port};
use listen::Listener;
use live::world::{Alarm, Clock};
use orders::Orders;
use outlet::Outlet;
use port::HEARD_MAX;
use shell::{End, Shell};
use signals::Signals;
use std::io::{self, Write as _};
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::time::Duration;
use tokio::sync::mpsc;
use tracing::info;
use wire::gyro::dsp3000_command;

/// The base was commanded to stop and did not report that it is at rest.
const EXIT_NOT_AT_REST: u8 = 1;
/// A port could not be opened, or vanished and did not come back. (clap uses 2 for bad arguments.)
const EXIT_PORT: u8 = 3;
/// The system provides no threads, timers or signals.
const EXIT_SYSTEM: u8 = 4;

/// Time limit for the readers of stdout and stderr to take the remaining lines at the end.
const FLUSH_MAX: Duration = Duration::from_millis(500);

fn main() -> ExitCode {
    let setup = match Arguments::parse().setup() {
        Ok(setup) => setup,
        Err(cause) => Arguments::command().error(ErrorKind::ArgumentConflict, cause).exit(),
    };
    match run(setup) {
        Ok(status) => ExitCode::from(status),
        Err(cause) => {
            say(&cause);
            ExitCode::from(EXIT_SYSTEM)
        }
    }
}

/// Runs the process and returns its exit status, or the reason why the system does not let it run.
fn run(setup: Setup) -> io::Result<u8> {
    let clock = Clock::start();
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let log = log::start()?;
    let reports = Outlet::spawn("stdout", io::stdout())?;
    let status = runtime.block_on(serve(setup, clock, &reports));
    reports.finish(FLUSH_MAX);
    log.finish(FLUSH_MAX);
    // A driver that hangs while it reopens a port must not delay the end.
    runtime.shutdown_background();
    status
}

async fn serve(setup: Setup, clock: Clock, reports: &Outlet) -> io::Result<u8> {
    let mut signals = Signals::install()?;
    let (sender, heard) = mpsc::channel(HEARD_MAX);
    let gyro_stream = setup.config.gyro.stream;
    // A DSP-3000 that lost power has lost the settings that it received at the start.
    let greeting = gyro_stream
        .format
        .facts()
        .takes_commands
        .then(|| dsp3000_command::Command::Output(gyro_stream.mode).encode());
    let gyro = port::open(Port::Gyro, setup.gyro, greeting, sender.clone(), clock).await;
    let base = match setup.base {
        None => Ok(None),
        Some(place) => port::open(Port::Base, place, None, sender, clock).await.map(Some),
    };
    let (gyro, base) = match (gyro, base) {
        (Ok(gyro), Ok(base)) => (gyro, base),
        (gyro, base) => {
            // Both errors are reported at once, so that the user can fix both in one go.
            for cause in [gyro.err(), base.err()].into_iter().flatten() {
                say(&cause);
            }
            return Ok(EXIT_PORT);
        }
    };
    let mut shell = Shell {
        controller: Controller::new(setup.config, clock.now()),
        clock,
        alarm: Alarm::new(clock)?,
        heard,
        // Replaced by those of each client.
        missions: mpsc::channel(1).1,
        gyro,
        base,
        reports: reports.sender(),
    };
    let Some(place) = setup.listen else {
        let orders = orders::read(io::BufReader::new(io::stdin()))?;
        return Ok(attend(&mut shell, orders, &mut signals).await.1);
    };
    let listener = match Listener::bind(place).await {
        Ok(listener) => listener,
        Err(cause) => {
            say(&format_args!("cannot listen for missions: {cause}"));
            return Ok(EXIT_PORT);
        }
    };
    loop {
        let client = match shell.wait_for(&mut signals, listener.client()).await {
            Ok(client) => client,
            Err(end) => return Ok(conclude(&mut shell, end, 0).await),
        };
        info!("a client is there");
        shell.controller = Controller::new(setup.config, clock.now());
        shell.reports = client.connection.reports.sender();
        let (end, status) = attend(&mut shell, client.orders, &mut signals).await;
        client.connection.close();
        if matches!(end, End::Signal(_) | End::PortLost(_)) {
            return Ok(status);
        }
    }
}

/// Carries out missions until something ends them; returns the cause and its exit status.
async fn attend(shell: &mut Shell, orders: Orders, signals: &mut Signals) -> (End, u8) {
    shell.missions = orders.missions;
    let end = shell.run(signals).await;
    (end, conclude(shell, end, orders.refused.load(Ordering::Relaxed)).await)
}

/// Brings the base to rest and returns the exit status.
async fn conclude(shell: &mut Shell, end: End, lines_refused: u64) -> u8 {
    let at_rest = shell.bring_to_rest().await;
    shell.log_end(end, at_rest, lines_refused);
    match end {
        End::PortLost(_) => EXIT_PORT,
        _ if !at_rest => EXIT_NOT_AT_REST,
        _ => 0,
    }
}

/// Writes one line to stderr, whatever the log level.
fn say(cause: &impl std::fmt::Display) {
    // If stderr is closed, the message is lost.
    let _ = writeln!(io::stderr(), "k2a-controller: {cause}");
}
