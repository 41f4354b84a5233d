//! Truth over time as it becomes known: steps, each with the moment from which it holds.

use crate::truth::Truth;
use std::collections::VecDeque;

/// From `at` on, until the next step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Step {
    pub(crate) at: i64,
    pub(crate) truth: Truth,
}

/// Steps between the operator that makes them and the one that takes them.
///
/// Unknown before the first step. Equal neighbours are one step, so what does not change costs nothing.
#[derive(Debug, Clone)]
pub(crate) struct Stream {
    steps: VecDeque<Step>,
    last: Truth,
    /// The start of the run: there is nothing before.
    start: i64,
    /// Every moment before this one is final.
    known: i64,
}

impl Stream {
    pub(crate) fn new() -> Self {
        Self { steps: VecDeque::new(), last: Truth::UNKNOWN, start: i64::MIN, known: i64::MIN }
    }

    /// The run starts at `at`.
    pub(crate) fn start(&mut self, at: i64) {
        self.start = at;
    }

    /// The moment behind the last that is final.
    pub(crate) fn known(&self) -> i64 {
        self.known
    }

    pub(crate) fn know(&mut self, until: i64) {
        self.known = self.known.max(until);
    }

    /// Each `at` is later than the one before. What looks ahead tells of moments before the run as well; of
    /// these the last is what the run starts with.
    pub(crate) fn push(&mut self, at: i64, truth: Truth) {
        let at = at.max(self.start);
        if self.steps.back().is_some_and(|step| step.at == at) {
            self.steps.pop_back();
            self.last = self.steps.back().map_or(Truth::UNKNOWN, |step| step.truth);
        }
        if truth == self.last {
            return;
        }
        debug_assert!(self.steps.back().is_none_or(|step| step.at < at), "steps come in order");
        self.last = truth;
        self.steps.push_back(Step { at, truth });
    }

    /// When the next step is, if it is final.
    pub(crate) fn next_at(&self) -> Option<i64> {
        self.steps.front().map(|step| step.at).filter(|at| *at < self.known)
    }

    /// Takes the next step, if it is final.
    pub(crate) fn pop(&mut self) -> Option<Step> {
        self.next_at().and_then(|_| self.steps.pop_front())
    }

    /// Takes the next step, if it is at `at`.
    pub(crate) fn pop_at(&mut self, at: i64) -> Option<Truth> {
        (self.next_at() == Some(at))
            .then(|| self.steps.pop_front().map(|step| step.truth))
            .flatten()
    }

    /// Takes all that is final.
    pub(crate) fn pour(&mut self, mut into: impl FnMut(Step)) {
        while let Some(step) = self.pop() {
            into(step);
        }
    }
}
