//! What the caller asks of a search, the models that it visits, and what it finds in a block.

use super::choose::Contender;
use super::state::State;
use crate::fit::Found;
use crate::judge::{Goes, Judge, Metric};
use crate::model::{Shape, Timing};
use crate::noise::NoiseModel;

/// Options of the caller for a block.
#[derive(Clone, Copy)]
pub struct Asked<'a> {
    /// This block's share of the risk of a false alarm.
    pub share: f64,
    /// Maximum number of causes.
    pub effects_max: usize,
    /// Its noise, if known.
    pub noise: Option<&'a NoiseModel>,
    /// The only kind of delay that it may have, if other axes determine it.
    pub timing: Option<Timing>,
}

/// A model with its held-out errors.
#[derive(Clone)]
pub(super) struct Step<'a> {
    /// The model.
    pub state: State<'a>,
    /// Its errors.
    pub metrics: Vec<Metric>,
}

impl<'a> Step<'a> {
    /// Judges the model of `state`.
    pub fn new(state: State<'a>, judge: &Judge<'_>) -> Self {
        let metrics = judge.judge(&state.terms, &state.noise);
        Self { state, metrics }
    }

    /// Number of fitted numbers of its added terms.
    pub fn numbers(&self) -> usize {
        let added = &self.state.terms[self.state.base..];
        added.iter().map(|term| term.width() + term.nonlinear().len()).sum()
    }
}

/// Result for a block.
#[derive(Debug, Clone)]
pub struct BlockFit {
    /// Terms of the given model, with their values.
    pub base: Vec<Found>,
    /// Terms that were added.
    pub effects: Vec<Found>,
    /// All terms with the values to apply to other data.
    pub applied: Vec<Found>,
    /// The noise that remains.
    pub noise: NoiseModel,
    /// Standard deviation of the innovation of a reading.
    pub floor: f64,
    /// Standard deviation of a variance of 1 in `noise`.
    pub scale: f64,
    /// Strongest candidates below the threshold.
    pub left: Vec<Contender>,
    /// The models from plain to rich.
    pub path: Vec<Waypoint>,
    /// Index of the chosen model.
    pub chosen: usize,
    /// Held-out errors of the choice: for each run, those of the model that would be chosen without it.
    pub nested: Vec<Metric>,
    /// The input that the residual depends on, if any: the residual is then not noise.
    pub goes: Option<Goes>,
}

/// A model on the path.
#[derive(Debug, Clone)]
pub struct Waypoint {
    /// Names of its effects.
    pub effects: Vec<String>,
    /// Number of causes among them.
    pub causes: usize,
    /// Its held-out errors.
    pub metrics: Vec<Metric>,
    /// For each metric, the margin in mean square within which the model counts as equal to the best.
    pub margins: Vec<f64>,
}

impl BlockFit {
    /// The fit of `state`, without what a choice among several adds.
    pub(super) fn new(
        state: &State<'_>,
        mut terms: Vec<Found>,
        (floor, scale): (f64, f64),
        left: Vec<Contender>,
    ) -> Self {
        let effects = terms.split_off(state.base);
        Self {
            base: terms,
            effects,
            applied: Vec::new(),
            noise: state.noise.clone(),
            floor,
            scale,
            left,
            path: Vec::new(),
            chosen: 0,
            nested: Vec::new(),
            goes: None,
        }
    }

    /// The given model and the added terms.
    pub fn all(&self) -> Vec<Found> {
        self.base.iter().chain(&self.effects).cloned().collect()
    }

    /// Shapes of the given model and of the added terms.
    pub fn shapes(&self) -> Vec<Shape> {
        self.base.iter().chain(&self.effects).map(|found| found.shape.clone()).collect()
    }
}
