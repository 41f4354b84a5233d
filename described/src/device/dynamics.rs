//! The variables of a device as time goes on.

use crate::description::{Law, Model, TIME};
use wire::time::{Span, Timestamp};

/// The most steps that one call integrates; the time behind them passes without. Assumption: a world wakes a
/// device more often than once a day.
const STEPS_MAX: u32 = 10_000_000;

/// The stages of the classic Runge-Kutta method: how far each goes with the slope before it, and its weight.
const STAGES: [(f64, f64); 4] = [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)];
const WEIGHTS: f64 = 6.0;

/// What the variables are now.
#[derive(Debug)]
pub(super) struct Dynamics {
    values: Vec<f64>,
    /// Where a stage tries.
    trial: Vec<f64>,
    /// One a state, for the stage and over all of them.
    slope: Vec<f64>,
    sum: Vec<f64>,
    start: Timestamp,
    now: Timestamp,
    not_finite: u64,
}

impl Dynamics {
    /// With all variables at zero and not yet started.
    pub(super) fn new(model: &Model) -> Self {
        let (slots, states) = (model.variables.count(), model.states.len());
        Self {
            values: vec![0.0; slots],
            trial: vec![0.0; slots],
            slope: vec![0.0; states],
            sum: vec![0.0; states],
            start: Timestamp::ZERO,
            now: Timestamp::ZERO,
            not_finite: 0,
        }
    }

    /// Power on: time at zero, states at their start.
    pub(super) fn start(&mut self, model: &Model, now: Timestamp) {
        (self.start, self.now) = (now, now);
        self.values[TIME] = 0.0;
        for (index, state) in model.states.iter().enumerate() {
            let start = state.start.value(&self.values);
            let start = finite(start, 0.0, &mut self.not_finite);
            self.values[model.variables.state(index)] = start;
            self.values[model.variables.last_state(index)] = start;
        }
        self.settle(model);
    }

    pub(super) fn get(&self, slot: usize) -> f64 {
        self.values.get(slot).copied().unwrap_or(f64::NAN)
    }

    pub(super) fn set(&mut self, slot: usize, value: f64) {
        if let Some(place) = self.values.get_mut(slot) {
            *place = value;
        }
    }

    pub(super) fn values(&self) -> &[f64] {
        &self.values
    }

    /// Values that were not finite, where what was before stayed.
    pub(super) const fn not_finite(&self) -> u64 {
        self.not_finite
    }

    /// Integrates over the whole steps that end by `now`.
    pub(super) fn advance(&mut self, model: &Model, now: Timestamp) {
        if model.states.is_empty() || now <= self.now {
            return;
        }
        for _ in 0..STEPS_MAX {
            let step = model.step.as_nanos();
            let count = self.now.since(self.start).as_nanos() / step + 1;
            let next = self.start + Span::from_nanos(step.saturating_mul(count));
            if next > now {
                return;
            }
            self.step(model, next);
        }
        self.now = now;
    }

    /// Integrates up to `now`, the last step a shorter one.
    pub(super) fn reach(&mut self, model: &Model, now: Timestamp) {
        self.advance(model, now);
        if now > self.now {
            self.step(model, now);
        }
    }

    fn seconds(&self, at: Timestamp) -> f64 {
        at.since(self.start).as_secs_f64()
    }

    fn step(&mut self, model: &Model, end: Timestamp) {
        let (from, to) = (self.seconds(self.now), self.seconds(end));
        let length = end.since(self.now).as_secs_f64();
        if model.states.iter().any(|state| matches!(state.law, Law::Rate(_))) {
            self.sum.fill(0.0);
            self.slope.fill(0.0);
            for (reach, weight) in STAGES {
                self.trial.copy_from_slice(&self.values);
                self.trial[TIME] = from + reach * length;
                for (index, slope) in self.slope.iter().enumerate() {
                    self.trial[model.variables.state(index)] += reach * length * slope;
                }
                follow(model, &mut self.trial, Moment::WithinStep, &mut 0);
                for (index, state) in model.states.iter().enumerate() {
                    if let Law::Rate(rate) = &state.law {
                        self.slope[index] = rate.value(&self.trial);
                        self.sum[index] += weight * self.slope[index];
                    }
                }
            }
            for (index, sum) in self.sum.iter().enumerate() {
                let slot = model.variables.state(index);
                let next = self.values[slot] + length * sum / WEIGHTS;
                self.values[slot] = finite(next, self.values[slot], &mut self.not_finite);
            }
        }
        self.values[TIME] = to;
        self.now = end;
        self.settle(model);
    }

    /// Gives the states with a value theirs, after something else has changed. From now on all states are
    /// those of one step before.
    pub(super) fn settle(&mut self, model: &Model) {
        follow(model, &mut self.values, Moment::EndOfStep, &mut self.not_finite);
        for index in 0..model.states.len() {
            let state = self.values[model.variables.state(index)];
            self.values[model.variables.last_state(index)] = state;
        }
    }
}

/// When states with a value are given theirs.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Moment {
    /// What is latched stays.
    WithinStep,
    EndOfStep,
}

/// Gives the states with a value theirs, each behind those that it needs.
fn follow(model: &Model, values: &mut [f64], moment: Moment, not_finite: &mut u64) {
    for index in &model.order {
        let value = match &model.states[*index].law {
            Law::Value(value) => value,
            Law::Latched(value) if moment == Moment::EndOfStep => value,
            Law::Latched(_) | Law::Rate(_) => continue,
        };
        let slot = model.variables.state(*index);
        values[slot] = finite(value.value(values), values[slot], not_finite);
    }
}

/// The value, or what was before where it is not finite.
pub(super) fn finite(value: f64, before: f64, not_finite: &mut u64) -> f64 {
    if value.is_finite() {
        return value;
    }
    *not_finite += 1;
    before
}
