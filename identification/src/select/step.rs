//! What the caller asks of a search, and a model that it visits.

use super::state::State;
use super::timing::Timing;
use crate::judge::{Judge, Metric};
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
        let metrics = judge.judge(&state.terms, &state.noise, &state.left_out);
        Self { state, metrics }
    }

    /// Number of fitted numbers of its added terms.
    pub fn numbers(&self) -> usize {
        let added = &self.state.terms[self.state.base..];
        added.iter().map(|term| term.width() + term.nonlinear().len()).sum()
    }
}
