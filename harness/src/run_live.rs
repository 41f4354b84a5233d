//! Runs plans in the live world, judges them and writes their run folders.

use crate::bench_file::BenchFile;
use crate::engine::{Action, Engine};
use crate::made::Made;
use crate::outcome::Outcome;
use crate::record::sink::RecordSink as _;
use crate::run::{Completed, Options, Prepared, Simulated, keep, summarise};
use crate::run_folder::{RunFolder, RunFolderError};
use crate::world::bench::Bench;
use crate::world::live::{DeviceUnderTest, LiveError, LiveWorld};
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
}

/// Runs a prepared plan in real time, judges it and writes its run folder. The bench file says which
/// roles real ports play; its command line goes before `device_under_test`.
///
/// # Errors
///
/// When the bench does not come up or the run folder cannot be made. A run that has begun ends with an
/// outcome, not with an error.
pub fn run_live_to_folder(
    prepared: &Prepared,
    options: &Options<'_>,
    device_under_test: DeviceUnderTest,
    bench_file: &BenchFile,
    pulse: &mut impl FnMut(Progress) -> bool,
) -> Result<Completed, LiveRunError> {
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
    let device_under_test = match &bench_file.controller {
        Some(controller) => DeviceUnderTest::Command(controller.command.clone()),
        None => device_under_test,
    };
    let mut world = LiveWorld::new(
        bench,
        engine,
        options.answers.clone(),
        device_under_test.clone(),
        bench_file.ports(),
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
