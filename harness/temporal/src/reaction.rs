//! Measurement of response times.

use crate::evaluator::{Evaluator, Stretch};
use crate::formula::Formula;
use std::collections::VecDeque;
use wire::time::{Span, Timestamp};

/// Measures the time from each moment at which one formula becomes true to the next at which another is true.
///
/// A response that is already true takes no time. A formula becomes true where `rises` of it is true. Several triggers
/// that wait for the same response each get their own measurement.
#[derive(Debug, Clone)]
pub struct Reaction {
    from: Evaluator,
    to: Evaluator,
    /// The next stretch of each formula, as far as final.
    asked: Option<Stretch>,
    met: Option<Stretch>,
    /// Whether the first formula was true when it was last known.
    was_true: bool,
    capacity: usize,
    waiting: VecDeque<Timestamp>,
    answers: VecDeque<Answer>,
    dropped: u64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Answer {
    pub asked: Timestamp,
    pub after: Span,
}

impl Reaction {
    /// Measures from the moment `from` becomes true to the moment `to` is true. Both read the same signals under the
    /// same numbers. At most `capacity` triggers wait for a response, and as many results wait for the caller.
    pub fn new(from: &Formula, to: &Formula, capacity: usize) -> Self {
        Self {
            from: Evaluator::new(from),
            to: Evaluator::new(to),
            asked: None,
            met: None,
            was_true: false,
            capacity,
            waiting: VecDeque::new(),
            answers: VecDeque::new(),
            dropped: 0,
        }
    }

    /// See [`Evaluator::update`].
    pub fn update(&mut self, time: Timestamp, values: &[(usize, f64)]) {
        if !self.from.reads(values) && !self.to.reads(values) {
            return;
        }
        self.from.advance(time);
        self.to.advance(time);
        self.from.update(time, values);
        self.to.update(time, values);
        self.measure();
    }

    /// See [`Evaluator::advance`].
    pub fn advance(&mut self, time: Timestamp) {
        self.from.advance(time);
        self.to.advance(time);
        self.measure();
    }

    /// Ends the run at `time`.
    pub fn finish(&mut self, time: Timestamp) {
        self.from.finish(time);
        self.to.finish(time);
        self.measure();
    }

    /// When the first response to a trigger from `since` on is certain, if no signal changes until then; `None` if that is
    /// not before `until`.
    pub fn due(&self, since: Timestamp, until: Timestamp) -> Option<Timestamp> {
        let mut ahead = self.clone();
        ahead.advance(until);
        let answer = std::iter::from_fn(|| ahead.take()).find(|answer| answer.asked >= since)?;
        // The moment itself is final once it is over.
        let lag = self.from.horizon().max(self.to.horizon()) + Span::from_nanos(1);
        Some(answer.asked + answer.after + lag)
    }

    /// The next result, in the order of the triggers.
    pub fn take(&mut self) -> Option<Answer> {
        self.answers.pop_front()
    }

    /// Times of the triggers without a response so far; after [`Self::finish`], of those that never got one.
    pub fn waiting(&self) -> impl Iterator<Item = Timestamp> {
        self.waiting.iter().copied()
    }

    /// Number of triggers not measured and results not taken, for lack of space.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Processes both formulas together as far as both are final. Both begin at the same moment.
    fn measure(&mut self) {
        loop {
            self.asked = self.asked.or_else(|| self.from.take());
            self.met = self.met.or_else(|| self.to.take());
            let (Some(asked), Some(met)) = (self.asked, self.met) else { return };
            self.ask(asked);
            if met.truth.holds() == Some(true) {
                self.answer(asked.from);
            }
            let to = asked.to.min(met.to);
            (self.asked, self.met) = (asked.behind(to), met.behind(to));
        }
    }

    /// Registers a trigger if the formula becomes true at the first moment of the stretch.
    fn ask(&mut self, stretch: Stretch) {
        let holds = stretch.truth.holds();
        if holds == Some(true) && !self.was_true {
            if self.waiting.len() < self.capacity {
                self.waiting.push_back(stretch.from);
            } else {
                self.dropped += 1;
            }
        }
        self.was_true = holds.unwrap_or(self.was_true);
    }

    fn answer(&mut self, at: Timestamp) {
        while let Some(asked) = self.waiting.pop_front() {
            if self.answers.len() < self.capacity {
                self.answers.push_back(Answer { asked, after: at - asked });
            } else {
                self.dropped += 1;
            }
        }
    }
}
