//! How long an answer takes.

use crate::evaluator::{Evaluator, Stretch};
use crate::formula::Formula;
use std::collections::VecDeque;
use wire::time::{Span, Timestamp};

/// Measures from each moment at which one formula becomes true to the next at which another is true.
///
/// An answer that is true already takes no time. A formula that was unknown just before does not become
/// true. Questions that wait for the same answer each get theirs.
#[derive(Debug, Clone)]
pub struct Reaction {
    from: Evaluator,
    to: Evaluator,
    /// What each of the two is next, as far as that is final.
    asked: Option<Stretch>,
    met: Option<Stretch>,
    was_false: bool,
    capacity: usize,
    waiting: VecDeque<Timestamp>,
    answers: VecDeque<Answer>,
    dropped: u64,
}

/// A question that was answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Answer {
    /// When it was asked.
    pub asked: Timestamp,
    /// How long the answer took.
    pub after: Span,
}

impl Reaction {
    /// Measures from where `from` becomes true to where `to` is true. Both read the same signals by the same
    /// numbers. At most `capacity` questions wait for their answer, and as many answers for the caller.
    pub fn new(from: &Formula, to: &Formula, capacity: usize) -> Self {
        Self {
            from: Evaluator::new(from),
            to: Evaluator::new(to),
            asked: None,
            met: None,
            was_false: false,
            capacity,
            waiting: VecDeque::new(),
            answers: VecDeque::new(),
            dropped: 0,
        }
    }

    /// As [`Evaluator::update`].
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

    /// As [`Evaluator::advance`].
    pub fn advance(&mut self, time: Timestamp) {
        self.from.advance(time);
        self.to.advance(time);
        self.measure();
    }

    /// The run ends at `time`.
    pub fn finish(&mut self, time: Timestamp) {
        self.from.finish(time);
        self.to.finish(time);
        self.measure();
    }

    /// The next answer, by the time of its question.
    pub fn take(&mut self) -> Option<Answer> {
        self.answers.pop_front()
    }

    /// When the questions were asked that have no answer so far; after [`Self::finish`] those that never got one.
    pub fn waiting(&self) -> impl Iterator<Item = Timestamp> {
        self.waiting.iter().copied()
    }

    /// Questions without an answer so far; after [`Self::finish`] those that never got one.
    pub fn unanswered(&self) -> usize {
        self.waiting.len()
    }

    /// Questions that were not measured and answers that nobody took, since there was no place for them.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Walks along both formulas together, as far as both are final. Both begin at the same moment.
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
            (self.asked, self.met) = (behind(asked, to), behind(met, to));
        }
    }

    /// The first moment of the stretch may be one at which the question is asked.
    fn ask(&mut self, stretch: Stretch) {
        let holds = stretch.truth.holds();
        if holds == Some(true) && self.was_false {
            if self.waiting.len() < self.capacity {
                self.waiting.push_back(stretch.from);
            } else {
                self.dropped += 1;
            }
        }
        self.was_false = holds == Some(false);
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

/// What is left of a stretch from `to` on.
fn behind(stretch: Stretch, to: Timestamp) -> Option<Stretch> {
    (to < stretch.to).then_some(Stretch { from: to, ..stretch })
}
