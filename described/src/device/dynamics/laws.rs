//! The laws of a device's states, in the form needed at each step.

use crate::description::{Law, Model};
use crate::expression::Expression;
use std::ops::Range;

/// When states with a value are updated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Moment {
    /// Latched states keep their value.
    WithinStep,
    EndOfStep,
}

#[derive(Debug, Clone)]
pub(super) struct Laws {
    rates: Box<[(usize, Expression)]>,
    /// Each after those that it depends on; with a flag for latched ones.
    values: Box<[(usize, Expression, bool)]>,
    states: Range<usize>,
    /// First slot of all states of the previous step.
    last: usize,
}

impl Laws {
    pub(super) fn of(model: &Model) -> Self {
        let slot = |index: usize| model.variables.state(index);
        let rate = |(index, state): (usize, &crate::description::State)| match &state.law {
            Law::Rate(rate) => Some((slot(index), rate.clone())),
            Law::Value(_) | Law::Latched(_) | Law::Held => None,
        };
        let value = |index: &usize| match &model.states[*index].law {
            Law::Value(value) => Some((slot(*index), value.clone(), false)),
            Law::Latched(value) => Some((slot(*index), value.clone(), true)),
            Law::Rate(_) | Law::Held => None,
        };
        Self {
            rates: model.states.iter().enumerate().filter_map(rate).collect(),
            values: model.order.iter().filter_map(value).collect(),
            states: slot(0)..slot(model.states.len()),
            last: model.variables.last_state(0),
        }
    }

    /// The states with a rate, by slot.
    pub(super) const fn rates(&self) -> &[(usize, Expression)] {
        &self.rates
    }

    /// Updates the states with a value, each after those that it depends on.
    pub(super) fn follow(&self, values: &mut [f64], moment: Moment, not_finite: &mut u64) {
        for (slot, value, is_latched) in &self.values {
            if !is_latched || moment == Moment::EndOfStep {
                values[*slot] = finite(value.value(values), values[*slot], not_finite);
            }
        }
    }

    /// Stores all states as those of the previous step.
    pub(super) fn remember(&self, values: &mut [f64]) {
        values.copy_within(self.states.clone(), self.last);
    }

    /// Restores the states with a value from `from`.
    pub(super) fn restore(&self, values: &mut [f64], from: &[f64]) {
        for (slot, ..) in &self.values {
            values[*slot] = from[*slot];
        }
    }
}

/// The value, or `before` if it is not finite.
pub(in crate::device) fn finite(value: f64, before: f64, not_finite: &mut u64) -> f64 {
    if value.is_finite() {
        return value;
    }
    *not_finite += 1;
    before
}
