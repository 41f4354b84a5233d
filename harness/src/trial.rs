//! Plans in somebody's `cargo test`: plain functions, no attributes.
//!
//! A [`Trial`] is a plan, the devices that it names, and whose controller is tested. [`Trial::run`] carries it out in
//! virtual time and gives a [`TrialRun`]: verdicts that print as a table. [`Trial::campaign`] looks for faults that
//! break it and gives the smallest as a plan.
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
//! A plan is a shipped one by its name, or a path; `cargo test` runs in the folder of the package. Device files and
//! descriptions of devices are looked for in `devices/` beside the plan, as everywhere.
//!
//! A run leaves a run folder. Without [`Trial::in_folder`] it is a temporary one, which is removed once the run passed
//! and its test did not fail; else it stays, and the message names it.
//!
//! # A controller of one's own
//!
//! In a [rig](crate::plan::rig) any [`Device`] plays a node that is under test: [`Trial::with_node`]. It hears bytes and
//! frames, sends bytes and frames, and is woken when it wants to be; `examples/battery-pack` has one, and its tests.
//!
//! [`Trial::with_controller`] puts any [`HostedController`] in the place of ours: it hears bytes and
//! frames, sends bytes and frames, takes missions and reports. `examples/rust-tests` is a crate with such a
//! controller and its tests. A controller that is a process is tested by `hil run --controller`, or here by
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
use crate::run::{Options, Prepared, Rerun, rerun, run_to_folder};
use crate::stopwatch::Stopwatch;
use controller::config::Config;
use folder::Folder;
use rig::hosted::{HostedController, Hosting};
use rig::operator::Answers;
use std::path::{Path, PathBuf};
use wire::device::Device;

/// The seed where none is given, as of `hil run`.
pub const SEED: u64 = 1;

/// How messages name a plan that is built in code.
const IN_CODE: &str = "a plan built in code";

/// A plan that is to be run, with everything that it names, read and checked.
#[derive(Debug, Clone)]
pub struct Trial {
    prepared: Prepared,
    seed: u64,
    answers: Answers,
    folder: Option<PathBuf>,
    level: Level,
}

impl Trial {
    /// The shipped plan of that name, or the one at that path.
    ///
    /// # Errors
    ///
    /// When the plan, or what it names, is missing or not right.
    pub fn load(plan: &str) -> Result<Self, TrialError> {
        Self::load_after(plan, &Made::default())
    }

    /// The same; calibrations and models that it uses may be those that an earlier run [made](TrialRun::made).
    ///
    /// # Errors
    ///
    /// When the plan, or what it names, is missing or not right.
    pub fn load_after(plan: &str, made: &Made) -> Result<Self, TrialError> {
        let library = Library::beside(plan);
        let source = library.open(Kind::Plan, plan).map_err(crate::run::PrepareError::from)?;
        Self::read(&library, source, made)
    }

    /// The plan with this text; `path` is how messages name it, and where it would lie.
    ///
    /// # Errors
    ///
    /// When the plan, or what it names, is missing or not right.
    pub fn parse(path: &str, text: &str) -> Result<Self, TrialError> {
        let source = Source { origin: path.to_owned(), text: text.to_owned() };
        Self::read(&Library::beside(path), source, &Made::default())
    }

    /// A plan that was built, or changed, in code. What it names is looked for in the working directory and among what
    /// ships.
    ///
    /// # Errors
    ///
    /// When the plan, or what it names, is missing or not right.
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
        Self { prepared, seed: SEED, answers, folder: None, level: Level::Events }
    }

    /// With this seed: the same seed gives the same record, byte for byte, as long as the controller does the same.
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// With a controller of one's own in the place of ours, for plans of a robot or a table. `start` makes one for each
    /// run; it is told the gyro's stream, how the base is connected, and the limits of motion. A plan of a
    /// [device](Plan::device) has no controller: the plan itself talks to the device.
    pub fn with_controller<C: HostedController + 'static>(
        mut self,
        start: impl Fn(&Config) -> C + Send + Sync + 'static,
    ) -> Self {
        self.prepared.hosting = Hosting::of(start);
        self
    }

    /// With your own device in the place of a node under test. `start` makes one for each run, at
    /// time zero; its ports are the lines that the rig file has the node on, in their order.
    pub fn with_node<D: Device + 'static>(
        mut self,
        node: &str,
        start: impl Fn() -> D + Send + Sync + 'static,
    ) -> Self {
        self.prepared.own.add(node, start);
        self
    }

    /// With these faults behind those of the plan.
    pub fn with_faults(mut self, faults: impl IntoIterator<Item = Fault>) -> Self {
        self.prepared.changed_plan().faults.faults.extend(faults);
        self
    }

    /// With these properties beside those of the plan.
    pub fn with_properties(mut self, properties: impl IntoIterator<Item = Property>) -> Self {
        self.prepared.changed_plan().properties.extend(properties);
        self
    }

    /// With these answers to what the plan asks a person.
    pub fn with_answers(mut self, answers: Answers) -> Self {
        self.answers = answers;
        self
    }

    /// The run folder, or the folder of a campaign, is this one and stays. An earlier run in it is removed.
    pub fn in_folder(mut self, folder: impl Into<PathBuf>) -> Self {
        self.folder = Some(folder.into());
        self
    }

    /// How much is recorded: events where it is not said, [`Level::Full`] every byte and frame.
    pub const fn with_record(mut self, level: Level) -> Self {
        self.level = level;
        self
    }

    /// Carries it out in virtual time, and judges it.
    ///
    /// # Errors
    ///
    /// When a fault or property that was added does not fit the plan, or the run folder cannot be made. What goes wrong
    /// in the run is an outcome.
    pub fn run(&self) -> Result<TrialRun, TrialError> {
        self.check()?;
        let folder = Folder::of(self.folder.as_deref())?;
        let answers = self.answers.clone();
        let options = Options { seed: self.seed, out: folder.path(), level: self.level, answers };
        let watch = Stopwatch::start();
        let done = run_to_folder(&self.prepared, &options, &mut |_| true, &|| watch.elapsed_s())?;
        Ok(TrialRun::new(done.summary, done.made, folder))
    }

    /// Who is under test hears again what was heard in the run of this folder, which was recorded at [`Level::Full`]: a
    /// controller that was changed since, say. The plan and its devices are those of that run.
    ///
    /// # Errors
    ///
    /// When the folder has no run, or its record does not hold what was heard.
    pub fn rerun(&self, recorded: &Path) -> Result<Rerun, TrialError> {
        let records = RunFolder::open(recorded)?.records()?;
        let seed = records.header().seed;
        Ok(rerun(&self.prepared, seed, records)?)
    }

    /// A search for faults that break it.
    pub fn campaign(&self) -> TrialCampaign {
        TrialCampaign::of(self.clone())
    }

    /// The plan as it is written; none where it was built or changed in code.
    fn text(&self) -> Option<&str> {
        self.prepared.files.plan()
    }

    /// What was added in code fits the plan and its bench, as what is written was checked to do.
    fn check(&self) -> Result<(), TrialError> {
        if self.text().is_none() {
            let Prepared { plan, rig, .. } = &self.prepared;
            let wrong = crate::run::PrepareError::from;
            plan.check(IN_CODE, "").map_err(wrong)?;
            plan.check_rig(IN_CODE, "", rig).map_err(wrong)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
