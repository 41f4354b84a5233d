//! Truth over time as it becomes known: steps, each with its first moment.

use crate::truth::Truth;
use std::collections::VecDeque;

/// A truth that holds from `at` until the next step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Step {
    pub(crate) at: i64,
    pub(crate) truth: Truth,
}

/// Steps between the operator that makes them and the one that takes them.
///
/// Unknown before the first step. Equal neighbours are merged, so a constant costs nothing.
#[derive(Debug, Clone)]
pub(crate) struct Stream {
    steps: VecDeque<Step>,
    /// Of the last step that was taken.
    taken: Truth,
    last: Truth,
    /// The start of the run; nothing exists before it.
    start: i64,
    /// Every moment before this one is final.
    known: i64,
}

impl Stream {
    pub(crate) fn new() -> Self {
        let (taken, last) = (Truth::UNKNOWN, Truth::UNKNOWN);
        Self { steps: VecDeque::new(), taken, last, start: i64::MIN, known: i64::MIN }
    }

    /// Starts the run at `at`.
    pub(crate) fn start(&mut self, at: i64) {
        self.start = at;
    }

    /// The moment after the last final one.
    pub(crate) fn known(&self) -> i64 {
        self.known
    }

    pub(crate) fn know(&mut self, until: i64) {
        self.known = self.known.max(until);
    }

    /// Appends a step; each `at` is later than the previous one. Operators that look ahead also produce moments before
    /// the run; the last of these is the value at its start.
    pub(crate) fn push(&mut self, at: i64, truth: Truth) {
        let at = at.max(self.start);
        if self.steps.back().is_some_and(|step| step.at == at) {
            self.steps.pop_back();
            self.last = self.steps.back().map_or(self.taken, |step| step.truth);
        }
        if truth == self.last {
            return;
        }
        debug_assert!(self.steps.back().is_none_or(|step| step.at < at), "steps come in order");
        self.last = truth;
        self.steps.push_back(Step { at, truth });
    }

    /// When the next step is, if final.
    pub(crate) fn next_at(&self) -> Option<i64> {
        self.steps.front().map(|step| step.at).filter(|at| *at < self.known)
    }

    pub(crate) fn pop(&mut self) -> Option<Step> {
        let step = self.next_at().and_then(|_| self.steps.pop_front())?;
        self.taken = step.truth;
        Some(step)
    }

    /// Takes the next step if it is at `at`.
    pub(crate) fn pop_at(&mut self, at: i64) -> Option<Truth> {
        if self.next_at() == Some(at) { self.pop().map(|step| step.truth) } else { None }
    }

    /// Takes all final steps.
    pub(crate) fn pour(&mut self, mut into: impl FnMut(Step)) {
        while let Some(step) = self.pop() {
            into(step);
        }
    }
}
