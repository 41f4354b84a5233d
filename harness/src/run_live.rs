//! Runs plans in the live world and judges them.

use crate::engine::{Action, Engine};
use crate::outcome::Summary;
use crate::record::sink::{Level, RecordSink as _};
use crate::run::{Prepared, Simulated, keep_artifacts, summarise, write_documents};
use crate::run_folder::{RunFolder, RunFolderError};
use crate::world::bench::Bench;
use crate::world::live::{DeviceUnderTest, LiveError, LiveWorld};
use crate::world::simulated::Progress;
use controller::calibration::Calibration;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use wire::time::Timestamp;

/// Name of the file that keeps what the device under test wrote to stderr.
pub const DEVICE_LOG: &str = "device-under-test.log";

/// How a live run is to be carried out and kept.
#[derive(Debug, Clone)]
pub struct LiveOptions<'a> {
    /// The seed of the emulated devices.
    pub seed: u64,
    /// Where the run folder goes.
    pub out: &'a Path,
    /// How much is recorded.
    pub level: Level,
    /// Answers to what a person would be asked.
    pub answers: BTreeMap<String, f64>,
    /// What is tested.
    pub device_under_test: DeviceUnderTest,
    /// Real ports by role; a role without one is emulated.
    pub ports: BTreeMap<String, String>,
}

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

/// Runs a prepared plan in real time, judges it and writes its run folder.
///
/// # Errors
///
/// When the bench does not come up or the run folder cannot be written. A run that has begun ends with
/// an outcome, not with an error.
pub fn run_live_to_folder(
    prepared: &Prepared,
    options: &LiveOptions<'_>,
    pulse: &mut impl FnMut(Progress) -> bool,
) -> Result<(Summary, BTreeMap<String, Calibration>), LiveRunError> {
    let folder = RunFolder::create(options.out)?;
    let header = prepared.header(options.seed);
    let mut sink = folder.record_sink(&header, options.level)?;
    let bench = Bench::new(prepared.devices.clone(), options.seed);
    let engine = Engine::new(
        Arc::clone(&prepared.plan),
        prepared.calibrations.clone(),
        bench.facts(),
        Timestamp::ZERO,
    );
    let mut world = LiveWorld::new(
        bench,
        engine,
        options.answers.clone(),
        options.device_under_test.clone(),
        options.ports.clone(),
    )?;
    let mut made = BTreeMap::new();
    let mut keep = |action: &Action| {
        if let Action::SaveCalibration { name, calibration } = action {
            made.insert(name.clone(), calibration.clone());
        }
    };
    let end = world.run(&folder.file(DEVICE_LOG), &mut sink, &mut keep, pulse)?;
    sink.finish();
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
    summary.device_under_test = match &options.device_under_test {
        DeviceUnderTest::InProcess => "in-process".to_owned(),
        DeviceUnderTest::OurProcess => "process".to_owned(),
        DeviceUnderTest::Command(words) => words.join(" "),
    };
    summary.wall_s = summary.simulated_s;
    keep_artifacts(&folder, prepared, options.seed, &run.made, &mut summary)?;
    if folder.file(DEVICE_LOG).is_file() {
        summary.artifacts.push(DEVICE_LOG.to_owned());
    }
    write_documents(&folder, &summary, &header)?;
    Ok((summary, run.made))
}
