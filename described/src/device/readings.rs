//! Values of the sent signals that are expressions.

use super::dynamics::Dynamics;
use crate::description::{Model, Sent};

/// Values of the signals of all sent messages. Messages that are sent at the same time are evaluated together.
#[derive(Debug, Clone)]
pub(super) struct Readings {
    values: Vec<f64>,
    /// The generation of the variables for which each block of expressions was evaluated.
    evaluated: Vec<u64>,
}

impl Readings {
    pub(super) fn new(model: &Model) -> Self {
        let signals = model.sent.last().map_or(0, |sent| sent.places.end);
        Self {
            values: vec![f64::NAN; signals],
            evaluated: vec![u64::MAX; model.expressions.count()],
        }
    }

    /// The signals of a message, those that are expressions with their present values.
    #[inline(always)]
    pub(super) fn of(&mut self, model: &Model, sent: &Sent, dynamics: &Dynamics) -> &mut [f64] {
        let generation = dynamics.generation();
        for block in &sent.blocks {
            if self.evaluated[*block] != generation {
                self.evaluated[*block] = generation;
                model.expressions.evaluate(*block, dynamics.values(), &mut self.values);
            }
        }
        &mut self.values[sent.places.clone()]
    }
}
