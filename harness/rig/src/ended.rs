//! How a run ended, in virtual or in real time.

use crate::engine::Ending;
use judge::checks::judge_all;
use judge::properties::{PropertyVerdict, Unjudged};
use judge::unseen::without_truth;
use plan::Declared;
use plan::made::Made;
use plan::observation::Observations;
use record::FaultSummary;
use record::outcome::{CommandSummary, Measurement, Outcome};
use wire::time::Timestamp;

/// Result of a run.
#[derive(Debug, Clone)]
pub struct Ended {
    /// How it ended.
    pub ending: Ending,
    /// Bench time at the end.
    pub end: Timestamp,
    /// Events handled; in real time, turns of the loop.
    pub events: u64,
    /// Everything observed.
    pub observations: Observations,
    /// Calibrations and models that the plan made, as far as the caller has kept them.
    pub made: Made,
    /// Number of items that the lines dropped for lack of room.
    pub dropped: u64,
    /// Commands of the bench that the plan asked for.
    pub commands: Vec<CommandSummary>,
    /// Summaries of the plan's faults.
    pub faults: Vec<FaultSummary>,
    /// Verdicts of the properties.
    pub properties: Vec<PropertyVerdict>,
    /// Properties of the plan that this bench cannot judge; empty in virtual time.
    pub unjudged: Vec<Unjudged>,
    /// Why the truth of the base is not known; `None` if it is.
    pub no_truth: Option<String>,
    /// What no measurement covers, one sentence each.
    pub notes: Vec<String>,
    /// Whether the controller reported a problem; `false` on a rig without a controller.
    pub announced: bool,
}

impl Ended {
    /// A run in which nothing happened.
    pub fn at_once(ending: Ending) -> Self {
        Self {
            ending,
            end: Timestamp::ZERO,
            events: 0,
            observations: Observations::default(),
            made: Made::default(),
            dropped: 0,
            commands: Vec::new(),
            faults: Vec::new(),
            properties: Vec::new(),
            unjudged: Vec::new(),
            no_truth: None,
            notes: Vec::new(),
            announced: false,
        }
    }

    /// Judges these measurements; those of a truth that the bench does not know are not judged.
    pub fn judge(&self, declared: &[Declared]) -> (Vec<Measurement>, Outcome) {
        judged(declared, &self.observations, self.no_truth.as_deref())
    }
}

/// Judges these measurements; those of a truth that the bench does not know, for the reason `no_truth`, are not judged.
pub fn judged(
    declared: &[Declared],
    observations: &Observations,
    no_truth: Option<&str>,
) -> (Vec<Measurement>, Outcome) {
    let (mut measurements, judged) = judge_all(declared, observations);
    let judged = match no_truth {
        Some(why) => without_truth(declared, &mut measurements, why),
        None => judged,
    };
    (measurements, judged)
}
