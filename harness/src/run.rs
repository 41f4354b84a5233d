//! Runs plans in the simulated world and judges them: the way from files to a summary.
//!
//! [`Prepared::load`] reads a plan and what it names; [`run_to_folder`] runs it and leaves a run
//! folder; [`verdicts`] runs it and keeps nothing; [`judge_again`] judges what was recorded earlier.

mod again;
mod declared;
mod device;
mod keep;
mod recorded_properties;
mod subject;

pub use again::{IMPORTED, JudgedAgain, judge_again, unfinished};
#[cfg(feature = "live")]
pub(crate) use keep::keep;
pub use keep::{
    Completed, Options, run_to_folder, run_to_folder_across, run_to_folder_watched, summarise,
    write_documents,
};
pub use subject::{Subject, SubjectError, load_description};

use crate::calibrations::{self, CalibrationError};
use crate::checks::judge_all;
use crate::engine::{Action, Ending, Engine};
use crate::hosted::Hosting;
use crate::library::{Kind, Library, LibraryError, Source};
use crate::made::Made;
use crate::models::{self, ModelError};
use crate::observation::Observation;
use crate::operator::Answers;
use crate::outcome::{Measurement, Outcome};
use crate::plan::{Plan, PlanError};
use crate::properties::{Monitor, Property, PropertyVerdict, Unjudged};
use crate::record::FaultSummary;
use crate::record::header::Header;
use crate::record::sink::{NullSink, RecordSink};
use crate::record::{Progress, VERSION};
use crate::world::bench::Bench;
use crate::world::crossing::{Crossing, Memory};
use crate::world::simulated::SimulatedWorld;
use controller::calibration::Calibration;
use emulators::device_file::Devices;
use identification::model::Model;
use std::collections::BTreeMap;
use std::sync::Arc;
use wire::time::Timestamp;

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
    /// The device file, or the description of a device, is not right.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Subject(#[from] SubjectError),
    /// A calibration is missing or not right.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Calibration(#[from] CalibrationError),
    /// An identified model is missing or not right.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Model(#[from] ModelError),
}

/// A plan and everything that it names, read and checked.
#[derive(Debug, Clone)]
pub struct Prepared {
    /// The plan.
    pub plan: Arc<Plan>,
    /// What it is carried out on.
    pub subject: Subject,
    /// The calibrations that it uses.
    pub calibrations: BTreeMap<String, Calibration>,
    /// The identified models that it uses.
    pub models: BTreeMap<String, Model>,
    /// Whose controller is tested in virtual time.
    pub hosting: Hosting,
    /// The mistake that the controller makes; see [`controller::Mutant`].
    #[cfg(feature = "mutants")]
    pub mutant: Option<controller::Mutant>,
}

impl Prepared {
    /// Reads the plan of that name or path. `made` is what earlier plans made.
    ///
    /// # Errors
    ///
    /// When anything is missing or not right.
    pub fn load(name: &str, made: &Made) -> Result<Self, PrepareError> {
        Self::load_from(&Library::beside(name), name, made)
    }

    /// The same, with the plan and what it names from `library`.
    ///
    /// # Errors
    ///
    /// When anything is missing or not right.
    pub fn load_from(library: &Library, name: &str, made: &Made) -> Result<Self, PrepareError> {
        Self::of_source(library, &library.open(Kind::Plan, name)?, made)
    }

    /// The plan in `source`, with what it names from `library`.
    ///
    /// # Errors
    ///
    /// When anything is missing or not right.
    pub fn of_source(
        library: &Library,
        source: &Source,
        made: &Made,
    ) -> Result<Self, PrepareError> {
        let plan = Plan::parse(&source.origin, &source.text)?;
        Self::of_plan(library, plan, source, made)
    }

    /// A plan that was checked by itself, with what it names from `library`; mistakes are shown in `source`.
    ///
    /// # Errors
    ///
    /// When anything is missing, or does not fit the plan.
    pub fn of_plan(
        library: &Library,
        plan: Plan,
        source: &Source,
        made: &Made,
    ) -> Result<Self, PrepareError> {
        let subject = Subject::of(library, &plan)?;
        subject.check(&plan, &source.origin, &source.text)?;
        let calibrations = calibrations::load(&plan, library, &made.calibrations)?;
        let models = models::load(&plan, library, &made.models)?;
        Ok(Self::new(Arc::new(plan), subject, calibrations, models))
    }

    /// A plan with what it names.
    pub fn new(
        plan: Arc<Plan>,
        subject: Subject,
        calibrations: BTreeMap<String, Calibration>,
        models: BTreeMap<String, Model>,
    ) -> Self {
        Self {
            plan,
            subject,
            calibrations,
            models,
            hosting: Hosting::default(),
            #[cfg(feature = "mutants")]
            mutant: None,
        }
    }

    /// The robot or table, as it is in the run with `seed`.
    pub(crate) fn bench(&self, devices: &Devices, seed: u64) -> Bench {
        let bench = Bench::new(devices.clone(), seed);
        #[cfg(feature = "mutants")]
        let bench = bench.with_mutant(self.mutant);
        bench
    }

    /// Who carries the plan out on `bench`, from time zero on.
    pub(crate) fn engine(&self, bench: &Bench) -> Engine {
        let (plan, calibrations) = (Arc::clone(&self.plan), self.calibrations.clone());
        Engine::new(plan, calibrations, bench.facts(), Timestamp::ZERO)
            .with_models(self.models.clone())
    }

    /// What the record says about itself.
    pub fn header(&self, seed: u64) -> Header {
        let mut header = header(&self.plan, seed);
        match &self.subject {
            Subject::Robot(devices) => header.lines = declared::lines(devices),
            Subject::Device(device) => device::name(&mut header, device),
        }
        header
    }
}

/// Reads the plan of that name or path, and nothing that it names.
///
/// # Errors
///
/// When it is missing or not right.
pub fn load_plan(library: &Library, name: &str) -> Result<Plan, PrepareError> {
    let source = library.open(Kind::Plan, name)?;
    Ok(Plan::parse(&source.origin, &source.text)?)
}

/// What a record of `plan` says about itself.
pub fn header(plan: &Plan, seed: u64) -> Header {
    Header {
        harness: VERSION.to_owned(),
        plan: plan.name.as_str().to_owned(),
        seed,
        quantities: declared::quantities(plan),
        lines: Vec::new(),
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
    /// Calibrations and models that the plan made.
    pub made: Made,
    /// What the lines dropped for want of room.
    pub dropped: u64,
    /// What became of the plan's faults.
    pub faults: Vec<FaultSummary>,
    /// What became of the properties that were watched.
    pub properties: Vec<PropertyVerdict>,
    /// Properties of the plan that this bench cannot judge; none in virtual time.
    pub unjudged: Vec<Unjudged>,
}

/// Runs a prepared plan in virtual time. `pulse` is called now and then; false stops the run.
pub fn simulate(
    prepared: &Prepared,
    seed: u64,
    answers: &Answers,
    sink: &mut impl RecordSink,
    pulse: &mut impl FnMut(Progress) -> bool,
) -> Simulated {
    simulate_across(Memory, prepared, seed, answers, sink, pulse)
}

/// The same, with everything on a line sent through `crossing` on its way.
pub fn simulate_across(
    crossing: impl Crossing,
    prepared: &Prepared,
    seed: u64,
    answers: &Answers,
    sink: &mut impl RecordSink,
    pulse: &mut impl FnMut(Progress) -> bool,
) -> Simulated {
    let declared = prepared.plan.properties.as_slice();
    let watched = (!declared.is_empty()).then_some(declared);
    go(crossing, prepared, seed, answers, watched, sink, pulse)
}

/// As [`simulate`], with all properties judged where the plan declares none. The run and its record are the same.
pub fn simulate_watched(
    prepared: &Prepared,
    seed: u64,
    answers: &Answers,
    sink: &mut impl RecordSink,
    pulse: &mut impl FnMut(Progress) -> bool,
) -> Simulated {
    let watched = Some(prepared.plan.properties.as_slice());
    go(Memory, prepared, seed, answers, watched, sink, pulse)
}

fn go(
    crossing: impl Crossing,
    prepared: &Prepared,
    seed: u64,
    answers: &Answers,
    watched: Option<&[Property]>,
    sink: &mut impl RecordSink,
    pulse: &mut impl FnMut(Progress) -> bool,
) -> Simulated {
    let devices = match &prepared.subject {
        Subject::Robot(devices) => devices,
        Subject::Device(device) => {
            return device::simulate(prepared, device, seed, answers, sink, pulse);
        }
    };
    let bench = prepared.bench(devices, seed);
    let engine = prepared.engine(&bench);
    let mut world = SimulatedWorld::across(crossing, bench, engine)
        .with_controller(&prepared.hosting)
        .with_answers(answers.clone())
        .with_faults(seed);
    if let Some(properties) = watched {
        world = world.with_monitor(properties);
    }
    let mut made = Made::default();
    let mut keep = |action: &Action| action.keep_in(&mut made);
    let mut ending = world.run(sink, &mut keep, pulse);
    finish(sink, &mut ending);
    let monitor = world.take_monitor();
    Simulated {
        ending,
        end: world.now(),
        events: world.events(),
        observations: world.engine().observations().values().flatten().cloned().collect(),
        made,
        dropped: world.dropped(),
        faults: world.faults().to_vec(),
        properties: monitor.map(Monitor::verdicts).unwrap_or_default(),
        unjudged: Vec::new(),
    }
}

/// Closes the record; a run whose record is not whole is broken.
pub(crate) fn finish(sink: &mut impl RecordSink, ending: &mut Ending) {
    sink.finish();
    if let Some(error) = sink.failed() {
        ending.outcome = Outcome::Error;
        ending.reason = Some(format!("failed to write the record: {error}"));
    }
}

/// What a run came to when nothing of it is kept.
#[derive(Debug, Clone)]
pub struct Verdicts {
    /// How it ended, before anything was judged.
    pub ending: Ending,
    /// What was measured.
    pub measurements: Vec<Measurement>,
    /// Calibrations and models that the plan made.
    pub made: Made,
}

impl Verdicts {
    /// The run went to its end, so that the measurements rest on everything that they should.
    pub fn is_complete(&self) -> bool {
        self.ending.outcome == Outcome::Passed
    }
}

/// Runs a prepared plan for its verdicts alone. `pulse` is called now and then; false stops the run.
pub fn verdicts(
    prepared: &Prepared,
    seed: u64,
    answers: &Answers,
    pulse: &mut impl FnMut(Progress) -> bool,
) -> Verdicts {
    let run = simulate(prepared, seed, answers, &mut NullSink, pulse);
    let (measurements, _) = judge_all(&prepared.plan.measurements, &run.observations);
    Verdicts { ending: run.ending, measurements, made: run.made }
}
