//! A search for faults that break a trial.

use super::broken::{Smallest, TrialFindings};
use super::folder::Folder;
use super::{Trial, TrialError};
use crate::campaign::{
    self, Case, CaseResult, Course, Executor as _, Found, Guided, Journal, Regression, Settings,
    Space, Targets,
};
use crate::executors::Simulated;
use crate::faults::FaultKind;
use crate::outcome::Outcome;
use crate::run::Prepared;
use crate::run_folder::RunFolderError;
use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZeroUsize;
use std::path::Path;
use std::thread::available_parallelism;

/// Default number of cases: a few seconds for a plan of one minute.
pub const CASES: u64 = 200;
/// Most faults of one case, as in `hil campaign`.
const FAULTS_MAX: usize = 4;
/// Attempts to shrink one case, as in `hil campaign`.
const SHRINK_MAX: u64 = 500;
/// File name of the journal of cases.
const JOURNAL: &str = "cases.jsonl";

/// Injects faults into a trial, as `hil campaign` does: the same seed draws the same cases, on any number of
/// processors.
#[derive(Debug, Clone)]
pub struct TrialCampaign {
    trial: Trial,
    cases: u64,
    faults: Vec<String>,
    must_pass: bool,
}

impl TrialCampaign {
    pub(super) const fn of(trial: Trial) -> Self {
        Self { trial, cases: CASES, faults: Vec::new(), must_pass: false }
    }

    /// Sets the number of cases; [`CASES`] by default.
    pub const fn cases(mut self, cases: u64) -> Self {
        self.cases = cases;
        self
    }

    /// Restricts the kinds of faults, by the names of `hil list faults`; by default all that can strike the bench.
    pub fn faults(mut self, kinds: &[&str]) -> Self {
        self.faults = kinds.iter().map(|&kind| kind.to_owned()).collect();
        self
    }

    /// Judges in each case whether the plan comes to its end with every measurement in its band, in place of its properties:
    /// those are not judged then. A plan without measurements only has to come to its end.
    pub const fn must_pass(mut self) -> Self {
        self.must_pass = true;
        self
    }

    /// Runs the cases. Judges the properties of the plan, or all if it declares none; a plan of the user's own device
    /// has to pass.
    ///
    /// # Errors
    ///
    /// When a property breaks without any fault, when no fault can strike, or when the folder cannot be written.
    pub fn run(&self) -> Result<TrialFindings, TrialError> {
        let trial = &self.trial;
        trial.check()?;
        let prepared = &trial.prepared;
        let executor = Simulated::new(prepared.clone(), trial.answers.clone());
        let executor = if self.must_pass { executor.that_must_pass() } else { executor };
        let clean = executor.without_faults(trial.seed);
        let states = self.states(&clean.1.reached);
        let space = self.space(prepared, clean)?;
        let folder = Folder::of(trial.folder.as_deref())?;
        let mut journal = opened(folder.path(), &self.what())?;
        let threads = available_parallelism().unwrap_or(NonZeroUsize::MIN);
        let settings = Settings { cases: self.cases, threads, shrink_max: SHRINK_MAX };
        let mut search = Guided::new(&space, trial.seed);
        let pulse = &mut |_: &_| true;
        let done = campaign::run(&executor, &mut search, &states, &settings, &mut journal, pulse)?;
        let smallest = done.found.iter().map(|found| self.keep(found, folder.path()));
        let smallest = smallest.collect::<Result<_, _>>()?;
        Ok(TrialFindings::new(done, smallest, folder))
    }

    /// The space of faults, after a check that the plan holds without any.
    fn space(
        &self,
        prepared: &Prepared,
        (course, clean): (Course, CaseResult),
    ) -> Result<Space, TrialError> {
        let plan = &prepared.plan;
        let name = || plan.name.as_str().to_owned();
        if let Some(unknown) = self.faults.iter().find(|name| FaultKind::typical(name).is_none()) {
            return Err(TrialError::UnknownFault { name: unknown.clone() });
        }
        if let Some(violated) = clean.violated.into_iter().next() {
            let campaign::Violated { property, at_s, what } = violated;
            return Err(TrialError::Broken { plan: name(), property, at_s, what });
        }
        if let Some((property, why)) = clean.never_judged.into_iter().next() {
            return Err(TrialError::NeverJudged { plan: name(), property, why });
        }
        if clean.outcome != Outcome::Passed.name() {
            return Err(TrialError::Unfinished { plan: name(), outcome: clean.outcome });
        }
        let (lines, targets) = (prepared.rig.struck(), Targets::of(&prepared.rig));
        let space = Space::among(plan, lines, course, FAULTS_MAX, &self.faults, &targets);
        if space.kinds().is_empty() {
            return Err(TrialError::NothingToStrike { plan: name() });
        }
        Ok(space)
    }

    /// States that should occur in some run, and whether the plan demands it; `reached` are those of the run without faults.
    fn states(&self, reached: &BTreeSet<String>) -> BTreeMap<String, bool> {
        if self.must_pass {
            return BTreeMap::new();
        }
        let Prepared { plan, rig, .. } = &self.trial.prepared;
        plan.unreached(&plan.judged(rig), reached)
    }

    /// Identity of the campaign: everything that determines its cases.
    fn what(&self) -> String {
        let Trial { prepared, seed, .. } = &self.trial;
        let (plan, faults) = (&prepared.plan, self.faults.join(", "));
        let known = self.trial.text().map_or_else(|| plan.faults.to_toml(), str::to_owned);
        let id = Case::default().id(&known);
        format!("{} ({id}) of a trial, seed {seed}, faults: {faults}", plan.name)
    }

    /// Saves the smallest case of a finding. A plan built or changed in code has no text: only its faults are saved.
    fn keep(&self, found: &Found, folder: &Path) -> Result<Smallest, TrialError> {
        let plan = &self.trial.prepared.plan;
        let case = &found.shrunk.case;
        let violated = &found.shrunk.result.violated;
        let what = violated.iter().find(|one| one.property == found.property);
        let what = what.map_or("", |violated| violated.what.as_str());
        let property = found.property.clone();
        let (name, text) = match self.trial.text() {
            Some(text) => {
                let plan = plan.name.as_str();
                let project = self.trial.prepared.project.as_deref();
                let property = &property;
                let small = found.shrunk.small();
                let again = self.trial.prepared.own.names().next().is_none().then_some("");
                let regression =
                    Regression { plan, text, project, property, what, case, small, again };
                (regression.name(), regression.to_toml(folder)?)
            }
            None => {
                let faults = case.schedule.beside(&plan.faults).to_toml();
                let head = format!("# The faults of {}, with seed {}\n\n", plan.name, case.seed);
                (format!("{}-{}", plan.name, campaign::slug(&property)), head + &faults)
            }
        };
        let path = folder.join(format!("{name}.toml"));
        std::fs::write(&path, &text)
            .map_err(|source| RunFolderError::Write { path: path.clone(), source })?;
        Ok(Smallest { property, what: what.to_owned(), seed: case.seed, plan: text, path })
    }
}

fn opened(folder: &Path, what: &str) -> Result<Journal, TrialError> {
    std::fs::create_dir_all(folder)
        .map_err(|source| RunFolderError::Write { path: folder.to_owned(), source })?;
    let path = folder.join(JOURNAL);
    // An earlier journal may come from a controller that has been fixed since.
    if let Err(source) = std::fs::remove_file(&path)
        && source.kind() != std::io::ErrorKind::NotFound
    {
        return Err(RunFolderError::Remove { path, source }.into());
    }
    Ok(Journal::open(&path, what)?)
}
