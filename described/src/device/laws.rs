//! What the states of a device follow, as it is needed at each step.

use super::dynamics::finite;
use crate::description::{Law, Model};
use crate::expression::Expression;
use std::ops::Range;

/// When states with a value are given theirs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Moment {
    /// What is latched stays.
    WithinStep,
    EndOfStep,
}

/// The laws of all states, by their slots.
#[derive(Debug, Clone)]
pub(super) struct Laws {
    rates: Box<[(usize, Expression)]>,
    /// Each behind those that it needs; whether it is latched.
    values: Box<[(usize, Expression, bool)]>,
    /// Of all states.
    states: Range<usize>,
    /// Of all states as they were one step before.
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

    /// Those that change at a rate, by their slots.
    pub(super) const fn rates(&self) -> &[(usize, Expression)] {
        &self.rates
    }

    /// Gives the states with a value theirs, each behind those that it needs.
    pub(super) fn follow(&self, values: &mut [f64], moment: Moment, not_finite: &mut u64) {
        for (slot, value, is_latched) in &self.values {
            if !is_latched || moment == Moment::EndOfStep {
                values[*slot] = finite(value.value(values), values[*slot], not_finite);
            }
        }
    }

    /// From now on all states are those of one step before.
    pub(super) fn remember(&self, values: &mut [f64]) {
        values.copy_within(self.states.clone(), self.last);
    }

    /// The states with a value, as they are in `from`.
    pub(super) fn restore(&self, values: &mut [f64], from: &[f64]) {
        for (slot, ..) in &self.values {
            values[*slot] = from[*slot];
        }
    }
}
