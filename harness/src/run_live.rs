//! Runs plans in the live world, judges them and writes their run folders.

use crate::bench_file::{BenchFile, ControllerSection};
use crate::engine::{Action, Engine};
use crate::made::Made;
use crate::operator::{Operator, Person};
use crate::outcome::Outcome;
use crate::port::PortSpec;
use crate::record::sink::RecordSink as _;
use crate::run::{Completed, Options, Prepared, Simulated, keep, summarise};
use crate::run_folder::{RunFolder, RunFolderError};
use crate::world::bench::Bench;
use crate::world::live::{
    ATTACH_MAX_DEFAULT, DeviceUnderTest, LATE_MAX_DEFAULT, LiveError, LiveWorld, Placement,
    PlacementError, Scheduling, Setting,
};
use crate::world::simulated::Progress;
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
    /// The bench does not fit the plan.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Placement(#[from] PlacementError),
}

/// What a live run is told beyond plan and options.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LiveSetting<'a> {
    /// The device under test, where the bench file names none.
    pub device_under_test: DeviceUnderTest,
    /// Which roles real ports play, and where the emulated ones are.
    pub bench: &'a BenchFile,
    /// Where an emulated base on CAN is that the bench file gives no port.
    pub can: PortSpec,
    /// What the scheduler is asked for; the bench file may ask for more.
    pub scheduling: Scheduling,
}

/// Runs a prepared plan in real time, judges it and writes its run folder. `person` can be asked for what
/// `options` has no answers to.
///
/// # Errors
///
/// When the bench cannot be used or does not come up, or the run folder cannot be made. A run that has begun ends with an
/// outcome, not with an error.
pub fn run_live_to_folder(
    prepared: &Prepared,
    options: &Options<'_>,
    setting: &LiveSetting<'_>,
    person: Option<Box<dyn Person>>,
    pulse: &mut impl FnMut(Progress) -> bool,
) -> Result<Completed, LiveRunError> {
    let bench = Bench::new(prepared.devices.clone(), options.seed);
    let setting = Setting {
        device_under_test: match &setting.bench.controller {
            Some(ControllerSection::Command(command)) => DeviceUnderTest::Command(command.clone()),
            Some(ControllerSection::InProcess) => DeviceUnderTest::InProcess,
            Some(ControllerSection::Attach(place)) => DeviceUnderTest::Attached(place.clone()),
            None => setting.device_under_test.clone(),
        },
        placement: Placement::new(setting.bench, bench.base_transport(), &setting.can)?,
        attach_max: setting.bench.timing.attach_max.unwrap_or(ATTACH_MAX_DEFAULT),
        late_max: setting.bench.timing.late_max.unwrap_or(LATE_MAX_DEFAULT),
        scheduling: if setting.bench.timing.realtime {
            Scheduling::RealTime
        } else {
            setting.scheduling
        },
    };
    let folder = RunFolder::create(options.out)?;
    let header = prepared.header(options.seed);
    let mut sink = folder.record_sink(&header, options.level)?;
    let engine = Engine::new(
        Arc::clone(&prepared.plan),
        prepared.calibrations.clone(),
        bench.facts(),
        Timestamp::ZERO,
    )
    .with_models(prepared.models.clone());
    let operator = Operator::live(options.answers.clone(), person);
    let mut world = LiveWorld::new(bench, engine, operator, setting.clone());
    let mut made = Made::default();
    let mut keep_made = |action: &Action| made.keep(action);
    let mut end = world.run(&folder.file(DEVICE_LOG), &mut sink, &mut keep_made, pulse)?;
    sink.finish();
    if let Some(error) = sink.failed() {
        end.ending.outcome = Outcome::Error;
        end.ending.reason = Some(format!("failed to write the record: {error}"));
    }
    drop(sink);
    let run = Simulated {
        ending: end.ending,
        end: end.end,
        events: end.events,
        observations: world.engine().observations().values().flatten().cloned().collect(),
        made,
        dropped: end.dropped,
        faults: Vec::new(),
        properties: Vec::new(),
    };
    let mut summary = summarise(prepared, options.seed, &run);
    "real".clone_into(&mut summary.clock);
    summary.bus = setting.placement.bus();
    summary.timing = Some(end.timing);
    summary.ports = end.ports;
    summary.device_under_test = match &setting.device_under_test {
        DeviceUnderTest::InProcess => "in-process".to_owned(),
        DeviceUnderTest::OurProcess => "process".to_owned(),
        DeviceUnderTest::Command(words) => words.join(" "),
        DeviceUnderTest::Attached(place) => format!("attached at {place}"),
    };
    summary.wall_s = summary.simulated_s;
    if folder.file(DEVICE_LOG).is_file() {
        summary.artifacts.push(DEVICE_LOG.to_owned());
    }
    Ok(keep(&folder, &header, summary, run))
}
