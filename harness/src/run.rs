//! Runs plans in the simulated world and judges them: the way from files to a summary.
//!
//! [`Prepared::load`] reads a plan and what it names; [`run_to_folder`] runs it and leaves a run
//! folder; [`verdicts`] runs it and keeps nothing; [`judge_again`] judges what was recorded earlier.

mod again;
mod declared;
mod keep;
mod recorded_properties;
mod rig_of;

pub use again::{IMPORTED, JudgedAgain, judge_again, unfinished};
#[cfg(feature = "live")]
pub(crate) use keep::keep;
pub use keep::{
    Completed, Options, run_to_folder, run_to_folder_across, run_to_folder_watched, summarise,
    write_documents,
};
#[cfg(feature = "logs")]
pub use rig_of::logged;
pub use rig_of::{RigError, load_description, load_recorded, load_rig, load_rig_named};

use crate::calibrations::{self, CalibrationError};
use crate::checks::judge_all;
use crate::engine::{Ending, Engine};
use crate::hosted::{Hosting, OwnDevices};
use crate::library::{Kind, Library, LibraryError, PLAN, Pack, Source};
use crate::made::Made;
use crate::models::{self, ModelError};
use crate::observation::Observation;
#[cfg(feature = "live")]
use crate::operator::RealRoles;
use crate::operator::{Answers, Operator};
use crate::outcome::{Measurement, Outcome};
use crate::plan::rig::{NodePart, RigNode, UnderTest};
use crate::plan::{Plan, PlanError, Rig, Speaker};
use crate::program::Programs;
use crate::properties::{Limits, Monitor, Property, PropertyVerdict, Unjudged};
use crate::record::FaultSummary;
use crate::record::header::{FILES_BYTES_MAX, Header, Node};
use crate::record::sink::{NullSink, RecordSink};
use crate::record::{Progress, VERSION};
#[cfg(feature = "live")]
use crate::rig::build_live;
use crate::rig::director::Director;
use crate::rig::simulate::Simulation;
use crate::rig::{self, build};
use crate::world::bench::Bench;
use crate::world::crossing::{CrossedLine, Crossing, Memory};
#[cfg(feature = "live")]
use crate::world::live::{PortPlans, Setting, Site};
use controller::calibration::Calibration;
use emulators::device_file::Devices;
use identification::model::Model;
use std::collections::BTreeMap;
use std::mem;
use std::sync::{Arc, PoisonError};
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
    Rig(#[from] RigError),
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
    pub rig: Rig,
    /// The calibrations that it uses.
    pub calibrations: BTreeMap<String, Calibration>,
    /// The identified models that it uses.
    pub models: BTreeMap<String, Model>,
    /// The files that all this is from; none where the plan was made in code.
    pub files: Arc<Pack>,
    /// Whose controller is tested in virtual time.
    pub hosting: Hosting,
    /// What plays nodes under test in this process.
    pub own: OwnDevices,
    /// Programs that play the others in virtual time.
    pub programs: Programs,
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
        let (library, opened) = library.clone().packing();
        let prepared = Self::of_plan(&library, plan, source, made)?;
        let mut files = mem::take(&mut *opened.lock().unwrap_or_else(PoisonError::into_inner));
        files.add(Kind::Plan, PLAN, source);
        Ok(Self { files: Arc::new(files), ..prepared })
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
        let rig = load_rig(library, &plan)?;
        plan.check_rig(&source.origin, &source.text, &rig)?;
        let calibrations = calibrations::load(&plan, library, &made.calibrations)?;
        let models = models::load(&plan, library, &made.models)?;
        Ok(Self::new(Arc::new(plan), rig, calibrations, models))
    }

    /// A plan with what it names.
    pub fn new(
        plan: Arc<Plan>,
        rig: Rig,
        calibrations: BTreeMap<String, Calibration>,
        models: BTreeMap<String, Model>,
    ) -> Self {
        Self {
            plan,
            rig,
            calibrations,
            models,
            files: Arc::default(),
            hosting: Hosting::default(),
            own: OwnDevices::default(),
            programs: Programs::default(),
            #[cfg(feature = "mutants")]
            mutant: None,
        }
    }

    /// The plan, to be changed in code: a record of it does not hold the text that it had.
    pub(crate) fn changed_plan(&mut self) -> &mut Plan {
        Arc::make_mut(&mut self.files).forget_plan();
        Arc::make_mut(&mut self.plan)
    }

    /// The robot or table, as it is in the run with `seed`.
    pub(crate) fn bench(&self, devices: &Devices, seed: u64) -> Bench {
        let bench = Bench::new(devices.clone(), seed);
        #[cfg(feature = "mutants")]
        let bench = bench.with_mutant(self.mutant);
        bench
    }

    /// Who carries the plan out, from time zero on; on `bench` where there is one.
    fn engine(&self, bench: Option<&Bench>) -> Engine {
        let engine =
            Engine::new(Arc::clone(&self.plan), Timestamp::ZERO).hearing(&self.rig.speakers);
        let engine = engine.with_models(self.models.clone());
        if let Some(bench) = bench {
            return engine.with_robot(bench.facts(), self.calibrations.clone());
        }
        // What does not happen in time does not happen: in a log as under test.
        let awaited =
            |node: &&RigNode| matches!(node.part, NodePart::UnderTest(_) | NodePart::Replayed(_));
        let awaited = self.rig.nodes.iter().filter(awaited).map(|node| node.name.clone());
        engine.awaiting(awaited.collect())
    }

    /// The rig at work in the run whose random numbers are of `seed`, who gives orders on it, and who watches over `properties`.
    fn simulated(
        &self,
        seed: u64,
        answers: &Answers,
        properties: Option<&[Property]>,
        start: build::Start<'_>,
    ) -> (rig::Rig, Director, Option<Monitor>) {
        let operator = Operator::simulated(answers.clone());
        let bench = self.rig.robot.as_ref().map(|devices| self.bench(devices, seed));
        let limits = bench.as_ref().map(|bench| Limits::of(&bench.controller_config()));
        let is_anything = |asked: &&[Property]| limits.is_some() || !asked.is_empty();
        let monitor = properties
            .filter(is_anything)
            .map(|asked| Monitor::new(asked, limits.as_ref(), &self.rig.speakers));
        let mut engine = self.engine(bench.as_ref());
        let (rig, away) = build::simulated(&self.rig, bench, (&self.hosting, start), seed);
        if let Some(why) = away.first() {
            engine.broke(Timestamp::ZERO, why);
        }
        (rig, Director::new(engine, operator), monitor)
    }

    /// The rig at ports of this machine, and who gives orders on it.
    #[cfg(feature = "live")]
    pub(crate) fn live(
        &self,
        seed: u64,
        setting: &Setting,
        operator: Operator,
    ) -> ((rig::Rig, PortPlans), Director) {
        let bench = self.rig.robot.as_ref().map(|devices| self.bench(devices, seed));
        let engine = self.engine(bench.as_ref());
        let (built, real) = match (&setting.site, bench, self.rig.device()) {
            (Site::Robot(placement, lines), Some(bench), _) => {
                let beside = (&self.rig, &lines[..], &self.own);
                (build_live::paper(bench, placement, beside, seed), placement.real_roles())
            }
            (Site::Device(player), _, Some(device)) => {
                let real = RealRoles { device: !player.is_emulated(), ..RealRoles::default() };
                (build_live::device(device, player, seed), real)
            }
            (Site::Lines(lines), ..) => {
                (build_live::rig(&self.rig, lines, &self.own, seed), RealRoles::default())
            }
            // A site is resolved from the rig; of another there is nothing here.
            _ => Default::default(),
        };
        let mut director = Director::new(engine, operator);
        director.real = real;
        (built, director)
    }

    /// What its lines cross where they go through the kernel.
    pub fn crossed_lines(&self) -> Vec<CrossedLine> {
        self.simulated(0, &Answers::default(), None, &|_| None).0.crossed_lines()
    }

    /// What is tested in virtual time, as a summary names it.
    pub(crate) fn device_under_test(&self) -> String {
        if self.rig.robot.is_some() {
            return "in-process".to_owned();
        }
        if let Some(device) = self.rig.device() {
            return format!("{}, emulated", device.name);
        }
        let under_test: Vec<&str> =
            self.rig.under_test().map(|(node, _)| node.name.as_str()).collect();
        match under_test.as_slice() {
            [] => format!("{}, emulated", self.rig.described_names().join(", ")),
            names if names.iter().all(|name| self.own.has(name)) => {
                format!("{}, in-process", names.join(", "))
            }
            _ => {
                let each = self.rig.under_test().map(|(node, how)| match how {
                    UnderTest::Command(words) if !self.own.has(&node.name) => {
                        format!("{}: {}", node.name, words.join(" "))
                    }
                    _ => format!("{}: in-process", node.name),
                });
                each.collect::<Vec<_>>().join(", ")
            }
        }
    }

    /// What the record says about itself.
    pub fn header(&self, seed: u64) -> Header {
        let mut lines = self.rig.robot.as_ref().map(|devices| declared::lines(devices));
        if let Some(device) = self.rig.device() {
            lines = Some(declared::line_of(device));
        }
        let nodes = match self.rig.is_short {
            true => Vec::new(),
            false => {
                let node = |(place, line): (usize, usize)| Node {
                    name: self.rig.nodes[place].name.clone(),
                    line: self.rig.line_name(line).to_owned(),
                };
                self.rig.ends().map(node).collect()
            }
        };
        let lines = lines.unwrap_or_default();
        let buses = declared::buses(&self.rig);
        let files = match self.files.bytes() {
            0..=FILES_BYTES_MAX => Arc::clone(&self.files),
            _ => Arc::default(),
        };
        Header { nodes, lines, buses, files, ..header(&self.plan, seed, &self.rig.speakers) }
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

/// What a record of `plan` says about itself, beside the lines of its rig.
pub fn header(plan: &Plan, seed: u64, speakers: &[Speaker]) -> Header {
    Header {
        harness: VERSION.to_owned(),
        plan: plan.name.as_str().to_owned(),
        seed,
        quantities: declared::quantities(plan, speakers),
        ..Header::default()
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
    let start = |place: usize| {
        let own = prepared.own.start(&prepared.rig.nodes[place].name);
        own.map(Ok).or_else(|| prepared.programs.start(&prepared.rig, place))
    };
    let seed = prepared.plan.seed_of_run(seed);
    let (rig, director, monitor) = prepared.simulated(seed, answers, watched, &start);
    let mut simulation = Simulation::new(crossing, rig, director, seed).with_monitor(monitor);
    let mut made = Made::default();
    let mut end = simulation.run(sink, &mut |action| action.keep_in(&mut made), pulse);
    finish(sink, &mut end.ending);
    let observations = simulation.director.engine.observations();
    Simulated {
        ending: end.ending,
        end: end.at,
        events: end.events,
        observations: observations.values().flatten().cloned().collect(),
        made,
        dropped: end.dropped,
        faults: end.faults,
        properties: end.monitor.map(|monitor| monitor.verdicts(end.at)).unwrap_or_default(),
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
