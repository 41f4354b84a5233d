//! Runs plans in the live world, judges them and writes their run folders.

use crate::bench_file::{BenchFile, ControllerSection, Medium, Role};
use crate::engine::{Action, Engine};
use crate::made::Made;
use crate::operator::{Operator, Person};
use crate::outcome::Outcome;
use crate::record::sink::RecordSink as _;
use crate::run::{Completed, Options, Prepared, Simulated, keep, summarise};
use crate::run_folder::{RunFolder, RunFolderError};
use crate::world::bench::Bench;
use crate::world::live::{DeviceUnderTest, LiveError, LiveWorld};
use crate::world::simulated::Progress;
use std::collections::BTreeMap;
use std::sync::Arc;
use wire::time::Timestamp;

/// Name of the file that keeps what the device under test wrote to stderr.
pub const DEVICE_LOG: &str = "device-under-test.log";

/// Why a live run left no summary.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum LiveRunError {
    /// The run folder cannot be written.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Folder(#[from] RunFolderError),
    /// The bench does not come up.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Live(#[from] LiveError),
    /// The bench file asks for more than the live world can do.
    #[error(transparent)]
    #[diagnostic(transparent)]
    NotYet(#[from] NotYet),
}

/// What a bench file may say and the live world cannot do.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
pub enum NotYet {
    /// A port of a kind that it does not open.
    #[error("the live world cannot use the port \"{port}\" for the {role} yet")]
    #[diagnostic(help(
        "name the path of a serial port, such as /dev/ttyUSB0, or leave [{role}] out"
    ))]
    Port {
        /// The role.
        role: &'static str,
        /// Its port.
        port: String,
    },
    /// A controller that somebody starts by hand.
    #[error("the live world cannot wait for a controller that is started by hand yet")]
    #[diagnostic(help(
        "give its command line: [controller] command = [\"./program\", \"{{gyro}}\"]"
    ))]
    Attach,
}

/// Runs a prepared plan in real time, judges it and writes its run folder. The bench file says which
/// roles real ports play; its command line goes before `device_under_test`. `person` can be asked for
/// what `options` has no answers to.
///
/// # Errors
///
/// When the bench cannot be used or does not come up, or the run folder cannot be made. A run that has begun ends with an
/// outcome, not with an error.
pub fn run_live_to_folder(
    prepared: &Prepared,
    options: &Options<'_>,
    device_under_test: DeviceUnderTest,
    bench_file: &BenchFile,
    person: Option<Box<dyn Person>>,
    pulse: &mut impl FnMut(Progress) -> bool,
) -> Result<Completed, LiveRunError> {
    let ports = ports(bench_file)?;
    let device_under_test = match &bench_file.controller {
        Some(ControllerSection::Command(command)) => DeviceUnderTest::Command(command.clone()),
        Some(ControllerSection::InProcess) => DeviceUnderTest::InProcess,
        Some(ControllerSection::Attach) => return Err(NotYet::Attach.into()),
        None => device_under_test,
    };
    let folder = RunFolder::create(options.out)?;
    let header = prepared.header(options.seed);
    let mut sink = folder.record_sink(&header, options.level)?;
    let bench = Bench::new(prepared.devices.clone(), options.seed);
    let engine = Engine::new(
        Arc::clone(&prepared.plan),
        prepared.calibrations.clone(),
        bench.facts(),
        Timestamp::ZERO,
    )
    .with_models(prepared.models.clone());
    let mut world = LiveWorld::new(
        bench,
        engine,
        Operator::live(options.answers.clone(), person),
        device_under_test.clone(),
        ports,
    )?;
    let mut made = Made::default();
    let mut keep_made = |action: &Action| made.keep(action);
    let mut end = world.run(&folder.file(DEVICE_LOG), &mut sink, &mut keep_made, pulse)?;
    sink.finish();
    if let Some(error) = sink.failed() {
        end.ending.outcome = Outcome::Error;
        end.ending.reason = Some(format!("failed to write the record: {error}"));
    }
    drop(sink);
    tracing::info!(
        late_max_s = end.late_max.as_secs_f64(),
        overrun_bytes = end.overrun_bytes,
        "live run over"
    );
    let run = Simulated {
        ending: end.ending,
        end: end.end,
        events: end.events,
        observations: world.engine().observations().values().flatten().cloned().collect(),
        made,
        dropped: 0,
    };
    let mut summary = summarise(prepared, options.seed, &run);
    "real".clone_into(&mut summary.clock);
    "pty".clone_into(&mut summary.bus);
    summary.device_under_test = match &device_under_test {
        DeviceUnderTest::InProcess => "in-process".to_owned(),
        DeviceUnderTest::OurProcess => "process".to_owned(),
        DeviceUnderTest::Command(words) => words.join(" "),
    };
    summary.wall_s = summary.simulated_s;
    if folder.file(DEVICE_LOG).is_file() {
        summary.artifacts.push(DEVICE_LOG.to_owned());
    }
    Ok(keep(&folder, &header, summary, run))
}

/// Paths of real serial ports by role, as the live world takes them.
fn ports(bench_file: &BenchFile) -> Result<BTreeMap<String, String>, NotYet> {
    let mut ports = BTreeMap::new();
    for (role, player) in bench_file.roles() {
        match player {
            Role::Emulated(None) => {}
            Role::Real(port)
                if role != "table"
                    && port.medium() == Medium::Serial
                    && port.address().starts_with('/') =>
            {
                ports.insert(role.to_owned(), port.address().to_owned());
            }
            Role::Real(port) | Role::Emulated(Some(port)) => {
                return Err(NotYet::Port { role, port: port.to_string() });
            }
        }
    }
    Ok(ports)
}

#[cfg(test)]
mod tests {
    use super::{BenchFile, NotYet, ports};

    #[test]
    fn a_port_that_would_be_left_aside_is_refused() {
        let bench = |text: &str| toml::from_str::<BenchFile>(text).unwrap();
        let taken = ports(&bench("[gyro]\nport = \"serial:/dev/ttyUSB0?baud=9600\"")).unwrap();
        assert_eq!(taken["gyro"], "/dev/ttyUSB0");
        for (role, port) in
            [("table", "/dev/ttyUSB1"), ("base", "can:can0"), ("gyro", "serial:usb:0403:6001")]
        {
            let refused = ports(&bench(&format!("[{role}]\nport = \"{port}\""))).unwrap_err();
            assert_eq!(refused, NotYet::Port { role, port: port.to_owned() });
        }
        assert!(ports(&bench("[base]\nport = \"can:vcan0\"\nemulated = true")).is_err());
    }
}
