//! Runs plans in the simulated world and judges them: from files to a summary.
//!
//! [`Prepared::load`] reads a plan and what it names; [`run_to_folder`] runs it and leaves a run folder; [`verdicts`]
//! runs it and keeps nothing; [`judge_again`] judges a recorded run, and [`rerun()`] repeats it for the device under
//! test.

mod absent;
mod again;
mod declared;
mod keep;
#[cfg(feature = "logs")]
mod logged;
mod prepared;
mod real_nodes;
mod recorded;
mod recorded_properties;
mod rig_of;
mod unheard;

pub use again::{IMPORTED, JudgedAgain, judge_again, unfinished};
#[cfg(feature = "live")]
pub(crate) use keep::keep;
pub use keep::{
    Completed, Options, run_to_folder, run_to_folder_watched, summarise, write_documents,
};
#[cfg(feature = "logs")]
pub use logged::logged;
pub use prepared::{PrepareError, Prepared, header, load_plan};
pub use recorded::{load_recorded, prepare_recorded};
pub use rig::ended::Ended;
pub use rig::rerun::{Clock, Difference, Moments, Rerun, RerunError, Said};
pub use rig_of::{RigError, load_description, load_rig, load_rig_named};

use crate::checks::judge_all;
use crate::made::Made;
use crate::outcome::{Measurement, Outcome, PropertySummary};
use crate::properties::Property;
use crate::record::Record;
use crate::record::reader::RecordError;
use crate::record::sink::NullSink;
use crate::run_folder::{RunFolder, RunFolderError};
use plan::Step;
use rig::crossing::MaybeCrossing;
use rig::engine::{Action, Ending};
use rig::operator::Answers;
use rig::rerun;
use rig::simulate::Simulation;
use rig::{Pulse, Sink};

/// Runs a prepared plan in virtual time. `pulse` is called now and then; `false` stops the run.
pub fn simulate(
    prepared: &Prepared,
    seed: u64,
    answers: &Answers,
    sink: Sink<'_>,
    pulse: Pulse<'_>,
) -> Ended {
    simulate_across(None, prepared, seed, answers, sink, pulse)
}

/// Like [`simulate`], with all traffic sent through `crossing`.
pub fn simulate_across(
    crossing: MaybeCrossing,
    prepared: &Prepared,
    seed: u64,
    answers: &Answers,
    sink: Sink<'_>,
    pulse: Pulse<'_>,
) -> Ended {
    let declared = prepared.plan.properties.as_slice();
    let watched = (!declared.is_empty()).then_some(declared);
    Underway::new(crossing, prepared, seed, answers, watched).run(sink, pulse)
}

/// Like [`simulate`], but judges [what a campaign judges](crate::plan::Plan::judged). The run and its record are the
/// same.
pub fn simulate_watched(
    prepared: &Prepared,
    seed: u64,
    answers: &Answers,
    sink: Sink<'_>,
    pulse: Pulse<'_>,
) -> Ended {
    let judged = prepared.plan.judged(&prepared.rig);
    Underway::new(None, prepared, seed, answers, Some(&judged)).run(sink, pulse)
}

/// A run in virtual time that is under way.
pub(crate) struct Underway {
    pub simulation: Simulation,
    /// What the plan has made so far.
    pub made: Made,
}

impl Underway {
    /// At time zero. `watched` are the properties that are judged; all where it is empty.
    pub(crate) fn new(
        crossing: MaybeCrossing,
        prepared: &Prepared,
        seed: u64,
        answers: &Answers,
        watched: Option<&[Property]>,
    ) -> Self {
        let start = |place: usize| prepared.start(place);
        let seed = prepared.plan.seed_of_run(seed);
        let (rig, director, monitor) = prepared.simulated(seed, answers, watched, &start);
        let simulation = Simulation::new(crossing, rig, director, seed).with_monitor(monitor);
        Self { simulation, made: Made::default() }
    }

    fn run(mut self, sink: Sink<'_>, pulse: Pulse<'_>) -> Ended {
        let keep = &mut |action: &_| Action::keep_in(action, &mut self.made);
        let end = self.simulation.run(sink, keep, pulse);
        self.ended(end, sink)
    }

    /// Runs from where it stands to the end of the plan.
    pub(crate) fn into_end(mut self, sink: Sink<'_>) -> Ended {
        let keep = &mut |action: &_| Action::keep_in(action, &mut self.made);
        let end = self.simulation.go_on(sink, keep, &mut |_| true);
        self.ended(end, sink)
    }

    fn ended(self, end: Ended, sink: Sink<'_>) -> Ended {
        let mut ended = Ended { made: self.made, ..end };
        finish(sink, &mut ended.ending);
        ended
    }
}

/// What is known of the moments of the run in this folder; that of virtual time if its summary is missing.
///
/// # Errors
///
/// When the summary or the record cannot be read.
pub fn moments_of(folder: &RunFolder) -> Result<Moments, RunFolderError> {
    let summary = folder.summary_if_any()?;
    let is_real = summary.is_some_and(|summary| summary.clock == "real");
    let clock = if is_real { Clock::Real } else { Clock::Virtual };
    Moments::of(clock, folder.records()?).map_err(|source| folder.unreadable(source))
}

/// Runs the devices under test of a prepared plan on the inputs of `records`, from a run with `seed`.
///
/// # Errors
///
/// When the record does not hold the inputs, or when no device is under test here.
pub fn rerun(
    prepared: &Prepared,
    seed: u64,
    moments: impl Into<Moments>,
    records: impl IntoIterator<Item = Result<Record, RecordError>>,
) -> Result<Rerun, RerunError> {
    let start = |place: usize| prepared.start(place);
    let seed = prepared.plan.seed_of_run(seed);
    let (rig, director, _) = prepared.simulated(seed, &Answers::default(), None, &start);
    match director.engine.why_ending() {
        Some(why) => Err(RerunError::NotStarted { why: why.to_owned() }),
        None => {
            let faults = &prepared.plan.faults;
            let struck = faults.faults.iter().cloned().zip(faults.chances(seed)).collect();
            let cycle = |step: &Step| match &step.action {
                plan::Action::PowerCycle(cycle) => {
                    let node = cycle.device.as_str().to_owned();
                    Some((step.action.to_string(), (node, cycle.off)))
                }
                _ => None,
            };
            let cycles = Step::walk(&prepared.plan.steps).filter_map(cycle).collect();
            rerun::rerun(rig, moments.into(), struck, cycles, records)
        }
    }
}

/// Closes the record; a run with an incomplete record ends with an error.
pub(crate) fn finish(sink: Sink<'_>, ending: &mut Ending) {
    sink.finish();
    if let Some(error) = sink.failed() {
        ending.outcome = Outcome::Error;
        ending.reason = Some(format!("failed to write the record: {error}"));
    }
}

/// Result of a run of which nothing is kept.
#[derive(Debug, Clone)]
pub struct Verdicts {
    /// How the run ended, before judgement.
    pub ending: Ending,
    /// The measurements.
    pub measurements: Vec<Measurement>,
    /// The properties of the plan, in its order.
    pub properties: Vec<PropertySummary>,
    /// Calibrations and models that the plan made.
    pub made: Made,
}

impl Verdicts {
    /// Whether the run went to its end, so that the measurements rest on complete data.
    pub fn is_complete(&self) -> bool {
        self.ending.outcome == Outcome::Passed
    }
}

/// Runs a prepared plan for its verdicts alone. `pulse` is called now and then; `false` stops the run.
pub fn verdicts(prepared: &Prepared, seed: u64, answers: &Answers, pulse: Pulse<'_>) -> Verdicts {
    let run = simulate(prepared, seed, answers, &mut NullSink, pulse);
    let (measurements, _) = judge_all(&prepared.plan.measurements, &run.observations);
    let properties = keep::properties(prepared, &run);
    Verdicts { ending: run.ending, measurements, properties, made: run.made }
}
