//! Runs plans in the simulated world and judges them: the way from files to a summary.

use crate::calibrations::{self, CalibrationError};
use crate::checks::judge_all;
use crate::engine::{Action, Ending, Engine};
use crate::junit;
use crate::library::{Kind, Library, LibraryError};
use crate::observation::Observation;
use crate::outcome::{Measurement, Outcome, Summary};
use crate::plan::{Plan, PlanError};
use crate::record::header::{Band, Header, Quantity};
use crate::record::sink::{Level, NullSink, RecordSink};
use crate::report;
use crate::run_folder::{RunFolder, RunFolderError};
use crate::world::bench::{Bench, DevicesError, load_devices};
use crate::world::simulated::{Progress, SimulatedWorld};
use controller::calibration::Calibration;
use emulators::device_file::Devices;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use wire::time::Timestamp;

/// Version of the harness.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Why a plan cannot be run at all: bad input.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum PrepareError {
    /// The plan cannot be had.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Library(#[from] LibraryError),
    /// The plan is not right.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Plan(#[from] PlanError),
    /// The device file is not right.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Devices(#[from] DevicesError),
    /// A calibration is missing or not right.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Calibration(#[from] CalibrationError),
}

/// A plan and everything that it names, read and checked.
#[derive(Debug, Clone)]
pub struct Prepared {
    /// The plan.
    pub plan: Arc<Plan>,
    /// The devices of its device file.
    pub devices: Devices,
    /// The calibrations that it uses.
    pub calibrations: BTreeMap<String, Calibration>,
}

impl Prepared {
    /// Reads the plan of that name or path. `made` are calibrations that earlier plans made.
    ///
    /// # Errors
    ///
    /// When anything is missing or not right.
    pub fn load(name: &str, made: &BTreeMap<String, Calibration>) -> Result<Self, PrepareError> {
        let library = Library::beside(name);
        let source = library.open(Kind::Plan, name)?;
        let plan = Plan::parse(&source.origin, &source.text)?;
        let devices = load_devices(&library, plan.devices.as_str())?;
        let calibrations = calibrations::load(&plan, &library, made)?;
        Ok(Self { plan: Arc::new(plan), devices, calibrations })
    }

    /// What the record says about itself.
    pub fn header(&self, seed: u64) -> Header {
        Header {
            harness: VERSION.to_owned(),
            plan: self.plan.name.as_str().to_owned(),
            seed,
            quantities: quantities(&self.plan),
        }
    }
}

/// What a run in the simulated world came to.
#[derive(Debug, Clone)]
pub struct Simulated {
    /// How it ended.
    pub ending: Ending,
    /// Bench time at the end.
    pub end: Timestamp,
    /// Events handled.
    pub events: u64,
    /// Everything observed, by quantity.
    pub observations: Vec<Observation>,
    /// Calibrations that the plan made.
    pub made: BTreeMap<String, Calibration>,
    /// What the lines dropped for want of room.
    pub dropped: u64,
}

/// Runs a prepared plan in virtual time. `pulse` is called now and then; false stops the run.
pub fn simulate(
    prepared: &Prepared,
    seed: u64,
    answers: &BTreeMap<String, f64>,
    sink: &mut impl RecordSink,
    pulse: &mut impl FnMut(Progress) -> bool,
) -> Simulated {
    let bench = Bench::new(prepared.devices.clone(), seed);
    let engine = Engine::new(
        Arc::clone(&prepared.plan),
        prepared.calibrations.clone(),
        bench.facts(),
        Timestamp::ZERO,
    );
    let mut world = SimulatedWorld::new(bench, engine).with_answers(answers.clone());
    let mut made = BTreeMap::new();
    let mut keep = |action: &Action| {
        if let Action::SaveCalibration { name, calibration } = action {
            made.insert(name.clone(), calibration.clone());
        }
    };
    let mut ending = world.run(sink, &mut keep, pulse);
    sink.finish();
    if let Some(error) = sink.failed() {
        ending.outcome = Outcome::Error;
        ending.reason = Some(format!("failed to write the record: {error}"));
    }
    Simulated {
        ending,
        end: world.now(),
        events: world.events(),
        observations: world.engine().observations().values().flatten().cloned().collect(),
        made,
        dropped: world.dropped(),
    }
}

/// Runs a prepared plan for its verdicts alone.
pub fn verdicts(prepared: &Prepared, seed: u64) -> (Outcome, Vec<Measurement>) {
    let none = BTreeMap::new();
    let run = simulate(prepared, seed, &none, &mut NullSink, &mut |_| true);
    let (measurements, judged) = judge_all(&prepared.plan.measurements, &run.observations);
    (run.ending.outcome.max(judged), measurements)
}

/// How a run is to be carried out and kept.
#[derive(Debug, Clone)]
pub struct Options<'a> {
    /// The seed.
    pub seed: u64,
    /// Where the run folder goes.
    pub out: &'a Path,
    /// How much is recorded.
    pub level: Level,
    /// Answers to what a person would be asked.
    pub answers: BTreeMap<String, f64>,
}

/// Runs a prepared plan in virtual time, judges it and writes its run folder. `wall_s` tells the time
/// that passed since it was called first.
///
/// # Errors
///
/// When the run folder cannot be written. The run itself ends with an outcome, not with an error.
pub fn run_to_folder(
    prepared: &Prepared,
    options: &Options<'_>,
    pulse: &mut impl FnMut(Progress) -> bool,
    wall_s: &mut impl FnMut() -> f64,
) -> Result<(Summary, BTreeMap<String, Calibration>), RunFolderError> {
    wall_s();
    let folder = RunFolder::create(options.out)?;
    let header = prepared.header(options.seed);
    let mut sink = folder.record_sink(&header, options.level)?;
    let run = simulate(prepared, options.seed, &options.answers, &mut sink, pulse);
    drop(sink);
    let mut summary = summarise(prepared, options.seed, &run);
    keep_artifacts(&folder, prepared, options.seed, &run.made, &mut summary)?;
    summary.wall_s = wall_s();
    write_documents(&folder, &summary, &header)?;
    Ok((summary, run.made))
}

/// Writes what the plan made into the run folder, and names it in the summary.
pub(crate) fn keep_artifacts(
    folder: &RunFolder,
    prepared: &Prepared,
    seed: u64,
    made: &BTreeMap<String, Calibration>,
    summary: &mut Summary,
) -> Result<(), RunFolderError> {
    for (name, calibration) in made {
        let file = format!("{name}.toml");
        let origin = format!("made by plan {}, seed {seed}", prepared.plan.name);
        folder.write_artifact(&file, calibrations::to_toml(calibration, &origin).as_bytes())?;
        summary.artifacts.push(file);
    }
    Ok(())
}

/// Writes summary, JUnit file and report of a run whose record is complete.
///
/// # Errors
///
/// When one of them cannot be written or the record cannot be read.
pub fn write_documents(
    folder: &RunFolder,
    summary: &Summary,
    header: &Header,
) -> Result<(), RunFolderError> {
    folder.write_summary(summary)?;
    if let Ok(xml) = junit::document([summary]) {
        folder.write_junit(&xml)?;
    }
    folder.write_report(&report::render(summary, header, folder.records()?))
}

pub(crate) fn summarise(prepared: &Prepared, seed: u64, run: &Simulated) -> Summary {
    let (measurements, judged) = judge_all(&prepared.plan.measurements, &run.observations);
    let outcome = match run.ending.outcome {
        Outcome::Passed => judged,
        ended => ended,
    };
    Summary {
        outcome,
        reason: run.ending.reason.clone(),
        plan: prepared.plan.name.as_str().to_owned(),
        title: prepared.plan.title.clone(),
        version: VERSION.to_owned(),
        seed,
        clock: "virtual".to_owned(),
        bus: "memory".to_owned(),
        device_under_test: "in-process".to_owned(),
        simulated_s: run.end.as_secs_f64(),
        wall_s: 0.0,
        events: run.events,
        measurements,
        artifacts: Vec::new(),
    }
}

/// The quantities that the plan judges, with the bands for single values.
fn quantities(plan: &Plan) -> Vec<Quantity> {
    let mut quantities: Vec<Quantity> = Vec::new();
    for declared in &plan.measurements {
        let names = std::iter::once(&declared.quantity)
            .chain(declared.check.second_quantity().map(|(_, name)| name));
        for name in names {
            if quantities.iter().any(|known| known.name == name.as_str()) {
                continue;
            }
            let entry = name.entry();
            quantities.push(Quantity {
                name: name.as_str().to_owned(),
                unit: entry.map_or_else(String::new, |entry| entry.unit.to_owned()),
                title: entry.map_or_else(String::new, |entry| entry.doc.to_owned()),
                bands: Vec::new(),
            });
        }
        let Some(band) = declared.check.value_band() else { continue };
        let known = quantities.iter_mut().find(|known| known.name == declared.quantity.as_str());
        if let Some(quantity) = known {
            quantity.bands.push(Band {
                measurement: declared.name.as_str().to_owned(),
                lower: band.lower(),
                upper: band.upper(),
                paper: declared.paper.clone(),
                tags: declared.filter.equalities(),
            });
        }
    }
    quantities
}
