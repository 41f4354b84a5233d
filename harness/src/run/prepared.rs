//! A plan and everything that it names, read and checked: the start of every run.

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
use crate::record::header::{FILES_BYTES_MAX, Header};
use controller::calibration::Calibration;
use described::FileError;
#[cfg(feature = "live")]
use described::Medium;
use emulators::device_file::Devices;
use identification::model::Model;
#[cfg(feature = "live")]
use live::world::{LineSite, Player, PortPlans, Setting, Site};
use plan::bench_file::Foreign;
use rig::bench::Bench;
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
use std::path::{Path, PathBuf};
use std::sync::{Arc, PoisonError};
use wire::time::Timestamp;

/// Why a plan cannot be run at all.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum PrepareError {
    /// The plan is missing or unreadable.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Library(#[from] LibraryError),
    /// The plan is invalid.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Plan(#[from] FileError),
    /// The device file or the description of a device is invalid.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Rig(#[from] RigError),
    /// A calibration is missing or invalid.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Calibration(#[from] CalibrationError),
    /// An identified model is missing or invalid.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Model(#[from] ModelError),
    /// The bench has a node that the rig lacks.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Foreign(#[from] Foreign),
    /// Records refer to nodes by their place in the rig.
    #[error("the rig of the plan \"{plan}\" has {theirs}, but the record has {recorded}")]
    #[diagnostic(help(
        "a record counts its nodes: its plan needs a rig with the same nodes on the same lines, in the same order"
    ))]
    OtherNodes {
        /// Name of the plan.
        plan: String,
        /// Nodes of its rig.
        theirs: String,
        /// Nodes of the record.
        recorded: String,
    },
}

impl PrepareError {
    /// Adds the place in the plan that names the missing file.
    fn placed(self, plan: &Source) -> Self {
        let missing = match self {
            Self::Rig(error) => return error.placed(plan).into(),
            Self::Library(ref error)
            | Self::Calibration(CalibrationError::Library(ref error))
            | Self::Model(ModelError::Library(ref error)) => plan.placed(error),
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
    /// The rig of the plan.
    pub rig: Rig,
    /// Calibrations used by the plan.
    pub calibrations: BTreeMap<String, Calibration>,
    /// Identified models used by the plan.
    pub models: BTreeMap<String, Model>,
    /// The files that were read; empty if the plan was made in code.
    pub files: Arc<Pack>,
    /// The folder in which they were searched before the shipped ones, if there was one.
    pub project: Option<PathBuf>,
    /// The controller under test in virtual time.
    pub hosting: Hosting,
    /// Devices in this process that play nodes under test.
    pub own: OwnDevices,
    /// Programs that play the other nodes under test in virtual time.
    pub programs: Programs,
    /// The deliberate mistake of the controller; see [`controller::Mutant`].
    #[cfg(feature = "mutants")]
    pub mutant: Option<controller::Mutant>,
}

impl Prepared {
    /// Reads the plan of that name or path. `made` holds the results of earlier plans.
    ///
    /// # Errors
    ///
    /// When a file is missing or invalid.
    pub fn load(name: &str, made: &Made) -> Result<Self, PrepareError> {
        Self::load_from(&Library::beside(name), name, made)
    }

    /// Like [`load`](Self::load), with all files from `library`.
    ///
    /// # Errors
    ///
    /// When a file is missing or invalid.
    pub fn load_from(library: &Library, name: &str, made: &Made) -> Result<Self, PrepareError> {
        Self::of_source(library, &library.open(Kind::Plan, name)?, made)
    }

    /// Reads the plan in `source`, with the files that it names from `library`.
    ///
    /// # Errors
    ///
    /// When a file is missing or invalid.
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
        let mut prepared = Self { files: Arc::new(files), ..prepared };
        let bytes = prepared.files.bytes();
        if bytes > FILES_BYTES_MAX {
            prepared.rig.notes.push(format!(
                "the files of the plan have {bytes} bytes, and a record keeps up to {FILES_BYTES_MAX}: \
                 `hil check`, `rerun` and `debug` of this run need --plan"
            ));
        }
        Ok(prepared)
    }

    /// Completes a checked plan with the files that it names from `library`; mistakes are shown in `source`.
    ///
    /// # Errors
    ///
    /// When a file is missing or does not fit the plan.
    pub fn of_plan(
        library: &Library,
        plan: Plan,
        source: &Source,
        made: &Made,
    ) -> Result<Self, PrepareError> {
        let placed = |error: PrepareError| error.placed(source);
        let library = &library.of(plan.project.as_deref());
        let rig = load_rig(library, &plan).map_err(PrepareError::from).map_err(placed)?;
        plan.check_rig(&source.origin, &source.text, &rig)?;
        let calibrations = calibrations::load(&plan, library, &made.calibrations);
        let calibrations = calibrations.map_err(PrepareError::from).map_err(placed)?;
        let models = models::load(&plan, library, &made.models);
        let models = models.map_err(PrepareError::from).map_err(placed)?;
        let project = library.folder().map(Path::to_owned);
        Ok(Self { project, ..Self::new(Arc::new(plan), rig, calibrations, models) })
    }

    /// Combines a plan with everything that it names.
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
            project: None,
            hosting: Hosting::default(),
            own: OwnDevices::default(),
            programs: Programs::default(),
            #[cfg(feature = "mutants")]
            mutant: None,
        }
    }

    /// The plan, for changes in code: a record will no longer hold its original text.
    pub(crate) fn changed_plan(&mut self) -> &mut Plan {
        Arc::make_mut(&mut self.files).forget_plan();
        Arc::make_mut(&mut self.plan)
    }

    /// The robot or table in the run with `seed`.
    pub(crate) fn bench(&self, devices: &Devices, seed: u64) -> Bench {
        let bench = Bench::new(devices.clone(), seed);
        #[cfg(feature = "mutants")]
        let bench = bench.with_mutant(self.mutant);
        bench
    }

    /// The engine of the plan, from time zero on; on `bench` if there is one.
    fn engine(&self, bench: Option<&Bench>) -> Engine {
        let engine =
            Engine::new(Arc::clone(&self.plan), Timestamp::ZERO).hearing(&self.rig.speakers);
        let mut engine = engine.with_models(self.models.clone());
        if let Some(lasted) = self.rig.logged {
            engine.known_until = Timestamp::ZERO + lasted;
            engine.left_out(&self.rig.foreign);
        }
        if let Some(bench) = bench {
            return engine.with_robot(bench.facts(), self.calibrations.clone());
        }
        // A missed limit is a failure, for a log as for a device under test.
        let awaited =
            |node: &&RigNode| matches!(node.part, NodePart::UnderTest(_) | NodePart::Replayed(_));
        let awaited = self.rig.nodes.iter().filter(awaited).map(|node| node.name.clone());
        engine.awaiting(awaited.collect())
    }

    /// Starts the device that plays the node under test at `place` in virtual time; `None` if nothing plays it.
    pub(super) fn start(&self, place: usize) -> Option<Result<Box<dyn NodeDevice>, String>> {
        let own = self.own.start(&self.rig.nodes[place].name);
        own.map(Ok).or_else(|| self.programs.start(&self.rig, place))
    }

    /// Builds the rig for the run with `seed`, its director, and the monitor of `properties`.
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

    /// Builds the rig at ports of this machine, and its director.
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
            // A bus has room for other programs: the plan is on it beside the device, and the port is theirs.
            (Site::Device(Player::Emulated(spec)), _, Some(device))
                if device.layout().medium() == Medium::Can =>
            {
                let site = LineSite { line: 0, spec: spec.clone(), beyond: Vec::new() };
                (live::at_ports::rig(&self.rig, &[site], &self.own, seed), RealRoles::default())
            }
            (Site::Device(player), _, Some(device)) => {
                let real = RealRoles { device: !player.is_emulated(), ..RealRoles::default() };
                (live::at_ports::device(device, player, seed), real)
            }
            (Site::Lines(lines), ..) => {
                (live::at_ports::rig(&self.rig, lines, &self.own, seed), RealRoles::default())
            }
            // A site is resolved from the rig, so no other combination occurs.
            _ => Default::default(),
        };
        let mut director = Director::new(engine, operator);
        director.real = real;
        (built, director)
    }

    /// The lines as a crossing sees them.
    pub fn crossed_lines(&self) -> Vec<CrossedLine> {
        // This starts no device.
        let plain = Self { hosting: Hosting::default(), ..self.clone() };
        plain.simulated(0, &Answers::default(), None, &|_| None).0.crossed_lines()
    }

    /// Name of the device under test in virtual time, for a summary.
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

    /// Header of the record.
    pub fn header(&self, seed: u64) -> Header {
        let mut lines = self.rig.robot.as_ref().map(|devices| declared::lines(devices));
        if let Some(device) = self.rig.device() {
            lines = Some(declared::line_of(device));
        }
        let nodes = declared::nodes(&self.rig);
        let lines = lines.unwrap_or_default();
        let buses = declared::buses(&self.rig);
        let files = match self.files.bytes() {
            0..=FILES_BYTES_MAX => Arc::clone(&self.files),
            _ => Arc::default(),
        };
        Header { nodes, lines, buses, files, ..header(&self.plan, seed, &self.rig.speakers) }
    }
}

/// Reads the plan of that name or path, without the files that it names.
///
/// # Errors
///
/// When it is missing or invalid.
pub fn load_plan(library: &Library, name: &str) -> Result<Plan, PrepareError> {
    let source = library.open(Kind::Plan, name)?;
    Ok(Plan::parse(&source.origin, &source.text)?)
}

/// Header of a record of `plan`, without the lines of its rig.
pub fn header(plan: &Plan, seed: u64, speakers: &[Speaker]) -> Header {
    Header {
        harness: VERSION.to_owned(),
        plan: plan.name.as_str().to_owned(),
        seed,
        quantities: declared::quantities(plan, speakers),
        steps: declared::steps(plan),
        ..Header::default()
    }
}
