//! A plan and everything that it names, read and checked: what every run begins with.

use super::declared;
use super::rig_of::{RigError, load_rig};
use crate::calibrations::{self, CalibrationError};
use crate::library::{Kind, Library, LibraryError, PLAN, Pack, Source};
use crate::made::Made;
use crate::models::{self, ModelError};
use crate::plan::rig::{NodePart, RigNode, UnderTest};
use crate::plan::{Plan, Rig, Speaker};
use crate::program::Programs;
use crate::properties::{Limits, Monitor, Property};
use crate::record::VERSION;
use crate::record::header::{FILES_BYTES_MAX, Header, Node};
use controller::calibration::Calibration;
use described::FileError;
use emulators::device_file::Devices;
use identification::model::Model;
#[cfg(feature = "live")]
use live::world::{PortPlans, Setting, Site};
use rig::bench::{Bench, DevicesError};
use rig::crossing::CrossedLine;
use rig::director::Director;
use rig::engine::Engine;
use rig::hosted::{Hosting, NodeDevice, OwnDevices};
#[cfg(feature = "live")]
use rig::operator::RealRoles;
use rig::operator::{Answers, Operator};
use rig::{self, build};
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
    Plan(#[from] FileError),
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

impl PrepareError {
    /// The same, shown in the plan where that names what is not there.
    fn placed(self, plan: &Source) -> Self {
        let missing = match &self {
            Self::Library(error)
            | Self::Rig(
                RigError::Library(error) | RigError::Devices(DevicesError::Library(error)),
            )
            | Self::Calibration(CalibrationError::Library(error))
            | Self::Model(ModelError::Library(error)) => plan.placed(error),
            _ => None,
        };
        missing.map_or(self, Self::Library)
    }
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
        let placed = |error: PrepareError| error.placed(source);
        let rig = load_rig(library, &plan).map_err(PrepareError::from).map_err(placed)?;
        plan.check_rig(&source.origin, &source.text, &rig)?;
        let calibrations = calibrations::load(&plan, library, &made.calibrations);
        let calibrations = calibrations.map_err(PrepareError::from).map_err(placed)?;
        let models = models::load(&plan, library, &made.models);
        let models = models.map_err(PrepareError::from).map_err(placed)?;
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

    /// What plays the node under test at `place` in virtual time; none where nothing does.
    pub(super) fn start(&self, place: usize) -> Option<Result<Box<dyn NodeDevice>, String>> {
        let own = self.own.start(&self.rig.nodes[place].name);
        own.map(Ok).or_else(|| self.programs.start(&self.rig, place))
    }

    /// The rig at work in the run whose random numbers are of `seed`, who gives orders on it, and who watches over `properties`.
    pub(super) fn simulated(
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
        let paper = bench.map(|bench| {
            let config = bench.controller_config();
            let program = |program: &_, config: &_| self.programs.controller(program, config);
            (bench, self.hosting.start(&config, program))
        });
        let (rig, away) = build::simulated(&self.rig, paper, start, seed);
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
                (live::at_ports::paper(bench, placement, beside, seed), placement.real_roles())
            }
            (Site::Device(player), _, Some(device)) => {
                let real = RealRoles { device: !player.is_emulated(), ..RealRoles::default() };
                (live::at_ports::device(device, player, seed), real)
            }
            (Site::Lines(lines), ..) => {
                (live::at_ports::rig(&self.rig, lines, &self.own, seed), RealRoles::default())
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
        // Nobody is started for it.
        let plain = Self { hosting: Hosting::default(), ..self.clone() };
        plain.simulated(0, &Answers::default(), None, &|_| None).0.crossed_lines()
    }

    /// What is tested in virtual time, as a summary names it.
    pub(crate) fn device_under_test(&self) -> String {
        if self.rig.robot.is_some() {
            return self.hosting.name();
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
