//! Plans in your own `cargo test`: plain functions, no attributes.
//!
//! A [`Trial`] is a plan with the devices that it names and the controller under test. [`Trial::run`] runs it in
//! virtual time and returns a [`TrialRun`]: verdicts that print as a table. [`Trial::campaign`] searches for faults
//! that break it and returns the smallest as a plan.
//!
//! ```
//! use harness::trial::{Trial, TrialError};
//!
//! // In a test: #[test] fn lines_are_straight() -> Result<(), TrialError> {
//! let run = Trial::load("straight-accuracy")?.with_seed(7).run()?;
//! assert!(run.passed(), "{run}");
//! assert!(run.value("stop_error").is_some_and(|error_m| error_m.abs() < 0.002), "{run}");
//! # Ok::<(), TrialError>(())
//! ```
//!
//! # Files
//!
//! A plan is the name of a shipped one, or a path; `cargo test` runs in the folder of the package. Device files and
//! descriptions of devices are looked up in `devices/` beside the plan, as everywhere.
//!
//! A run leaves a run folder. Without [`Trial::in_folder`] it is temporary: it is removed if the run passed and its
//! test did not fail; otherwise it stays, and the message names it.
//!
//! # Your own controller
//!
//! In a [rig](crate::plan::rig) any [`Device`] plays a node under test: [`Trial::with_node`]. It receives and sends
//! bytes and frames, and sets its own wake-ups; `examples/battery-pack` has one, with tests.
//!
//! [`Trial::with_controller`] replaces our controller with any [`HostedController`]: it receives and sends bytes and
//! frames, takes missions and reports; `examples/rust-tests` is a crate with such a controller and its tests. A
//! controller that is a process is tested by `hil run --controller`, or here by
//! [`Hosting::program`](rig::hosted::Hosting::program).

mod broken;
mod campaign;
mod error;
mod folder;
mod run;

pub use broken::{Smallest, TrialFindings};
pub use campaign::{CASES, TrialCampaign};
pub use error::TrialError;
pub use run::TrialRun;

use crate::faults::Fault;
use crate::library::{Kind, Library, Source};
use crate::made::Made;
use crate::plan::{Plan, Property};
use crate::record::run_folder::RunFolder;
use crate::record::sink::Level;
use crate::run::{Options, Prepared, Rerun, moments_of, rerun, run_to_folder};
use crate::stopwatch::Stopwatch;
use controller::config::Config;
use described::hint;
use folder::Folder;
use rig::hosted::{HostedController, Hosting};
use rig::operator::Answers;
use std::path::{Path, PathBuf};
use wire::device::Device;

/// Origin in messages of a plan built in code.
const IN_CODE: &str = "a plan built in code";

/// A plan to run, with everything that it names, read and checked.
#[derive(Debug, Clone)]
pub struct Trial {
    prepared: Prepared,
    seed: u64,
    answers: Answers,
    folder: Option<PathBuf>,
    level: Level,
}

impl Trial {
    /// Loads the shipped plan of that name, or the one at that path.
    ///
    /// # Errors
    ///
    /// When the plan, or a file that it names, is missing or invalid.
    pub fn load(plan: &str) -> Result<Self, TrialError> {
        Self::load_after(plan, &Made::default())
    }

    /// Like [`load`](Self::load), with calibrations and models that an earlier run [made](TrialRun::made).
    ///
    /// # Errors
    ///
    /// When the plan, or a file that it names, is missing or invalid.
    pub fn load_after(plan: &str, made: &Made) -> Result<Self, TrialError> {
        let library = Library::beside(plan);
        let source = library.open(Kind::Plan, plan).map_err(crate::run::PrepareError::from)?;
        Self::read(&library, source, made)
    }

    /// Reads the plan in `text`; `path` is its name in messages, and the place for files that it names.
    ///
    /// # Errors
    ///
    /// When the plan, or a file that it names, is missing or invalid.
    pub fn parse(path: &str, text: &str) -> Result<Self, TrialError> {
        let source = Source { origin: path.to_owned(), text: text.to_owned() };
        Self::read(&Library::beside(path), source, &Made::default())
    }

    /// Takes a plan that was built, or changed, in code. Files that it names are looked up in the working directory and
    /// among the shipped ones.
    ///
    /// # Errors
    ///
    /// When the plan, or a file that it names, is missing or invalid.
    pub fn of(plan: Plan) -> Result<Self, TrialError> {
        let source = Source { origin: IN_CODE.to_owned(), text: String::new() };
        plan.check(&source.origin, "").map_err(crate::run::PrepareError::from)?;
        let prepared = Prepared::of_plan(&Library::shipped(), plan, &source, &Made::default())?;
        Ok(Self::new(prepared))
    }

    fn read(library: &Library, source: Source, made: &Made) -> Result<Self, TrialError> {
        Ok(Self::new(Prepared::of_source(library, &source, made)?))
    }

    fn new(prepared: Prepared) -> Self {
        let answers = Answers::default();
        let seed = prepared.plan.seed(None);
        Self { prepared, seed, answers, folder: None, level: Level::Events }
    }

    /// Sets the seed, which is that of the plan, or 1: the same seed gives the same record, byte for byte, if the controller is deterministic.
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// Replaces our controller with your own, for plans of a robot or a table. `start` makes one for each run, from the
    /// gyro's stream, the connection of the base, and the limits of motion. A plan of a [device](Plan::device) has no
    /// controller: the plan itself talks to the device.
    pub fn with_controller<C: HostedController + 'static>(
        mut self,
        start: impl Fn(&Config) -> C + Send + Sync + 'static,
    ) -> Self {
        self.prepared.hosting = Hosting::of(start);
        self
    }

    /// Puts your own device in place of a node under test. `start` makes one for each run, at time zero; its ports are
    /// the lines of the node in the rig file, in their order.
    pub fn with_node<D: Device + 'static>(
        mut self,
        node: &str,
        start: impl Fn() -> D + Send + Sync + 'static,
    ) -> Self {
        self.prepared.own.add(node, start);
        self
    }

    /// Adds faults to those of the plan.
    pub fn with_faults(mut self, faults: impl IntoIterator<Item = Fault>) -> Self {
        self.prepared.changed_plan().faults.faults.extend(faults);
        self
    }

    /// Adds properties to those of the plan.
    pub fn with_properties(mut self, properties: impl IntoIterator<Item = Property>) -> Self {
        self.prepared.changed_plan().properties.extend(properties);
        self
    }

    /// Sets the answers to questions of the plan.
    pub fn with_answers(mut self, answers: Answers) -> Self {
        self.answers = answers;
        self
    }

    /// Sets the folder of the run or campaign. The folder stays; an earlier run in it is removed.
    pub fn in_folder(mut self, folder: impl Into<PathBuf>) -> Self {
        self.folder = Some(folder.into());
        self
    }

    /// Sets the level of recording: events by default, every byte and frame with [`Level::Full`].
    pub const fn with_record(mut self, level: Level) -> Self {
        self.level = level;
        self
    }

    /// Runs the trial in virtual time, and judges it.
    ///
    /// # Errors
    ///
    /// When an added fault or property does not fit the plan, or when the run folder cannot be made. Problems during
    /// the run are outcomes.
    pub fn run(&self) -> Result<TrialRun, TrialError> {
        self.check()?;
        let folder = Folder::of(self.folder.as_deref())?;
        let answers = self.answers.clone();
        let options = Options { seed: self.seed, out: folder.path(), level: self.level, answers };
        let watch = Stopwatch::start();
        let done = run_to_folder(&self.prepared, &options, &mut |_| true, &|| watch.elapsed_s())?;
        Ok(TrialRun::new(done.summary, done.made, folder))
    }

    /// Runs the devices under test again, for example a changed controller, on the inputs recorded in this folder at
    /// [`Level::Full`]. Plan and devices must be those of that run.
    ///
    /// # Errors
    ///
    /// When the folder has no run, or when its record does not hold the inputs.
    pub fn rerun(&self, recorded: &Path) -> Result<Rerun, TrialError> {
        self.check()?;
        let folder = RunFolder::open(recorded)?;
        let (moments, records) = (moments_of(&folder)?, folder.records()?);
        let header = records.header();
        let (seed, plan) = (header.seed, self.prepared.plan.name.as_str());
        if header.plan != plan {
            let recorded = header.plan.clone();
            return Err(TrialError::OtherPlan { plan: plan.to_owned(), recorded });
        }
        Ok(rerun(&self.prepared, seed, moments, records)?)
    }

    /// Starts a search for faults that break the trial.
    pub fn campaign(&self) -> TrialCampaign {
        TrialCampaign::of(self.clone())
    }

    /// The plan's text; `None` if it was built or changed in code.
    fn text(&self) -> Option<&str> {
        self.prepared.files.plan()
    }

    /// Checks that additions in code fit the plan and its bench; a text was checked on loading.
    fn check(&self) -> Result<(), TrialError> {
        if self.text().is_none() {
            let Prepared { plan, rig, .. } = &self.prepared;
            let wrong = crate::run::PrepareError::from;
            plan.check(IN_CODE, "").map_err(wrong)?;
            plan.check_rig(IN_CODE, "", rig).map_err(wrong)?;
        }
        let Prepared { plan, rig, own, .. } = &self.prepared;
        let known = rig.under_test_names();
        let Some(node) = own.names().find(|name| !known.contains(name)) else { return Ok(()) };
        let help = match rig.described(node) {
            Some(_) => "it is emulated; for Rust code in its place, its rig file says `under_test = { in_process = true }`, \
                        and `described_by` in place of `emulate`"
                .to_owned(),
            None => hint::proposal(node, &known),
        };
        let plan = plan.name.as_str().to_owned();
        Err(TrialError::NoSuchNode { plan, node: node.to_owned(), help })
    }
}

#[cfg(test)]
mod tests;
