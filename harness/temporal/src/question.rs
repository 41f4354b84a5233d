//! Whether a formula `a -> b` was put to the test: whether `a` was true, and `b` known then.

use crate::evaluator::{Evaluator, Stretch};
use crate::formula::{Formula, Premise};
use wire::time::Span;

/// Follows `a` and `b` beside the whole formula, as long as there is something to find.
#[derive(Debug, Clone)]
pub(crate) struct Question {
    premise: Premise,
    /// Until `a` was true while `b` was known.
    answered: Option<Evaluator>,
    /// Of a formula with a limit, until the caller knows that every signal has a value.
    unanswered: Option<Evaluator>,
}

impl Question {
    /// `None` for a formula that is no `a -> b`.
    pub(crate) fn of(formula: &Formula) -> Option<Self> {
        let premise = formula.premise.clone()?;
        let answered = Some(Evaluator::of(&premise.answered, formula));
        let has_limit = premise.limit > Span::ZERO;
        let unanswered = has_limit.then(|| Evaluator::of(&premise.unanswered, formula));
        Some(Self { premise, answered, unanswered })
    }

    pub(crate) fn follow(&mut self, mut to: impl FnMut(&mut Evaluator)) {
        self.answered.iter_mut().chain(&mut self.unanswered).for_each(&mut to);
        self.answered
            .take_if(|answered| std::iter::from_fn(|| true_from(answered)).next().is_some());
    }

    /// The next moments at which `a` is true and `b`, with all that it looks ahead to, is unknown; never if it does not look
    /// ahead.
    pub(crate) fn unanswered(&mut self) -> Option<Stretch> {
        true_from(self.unanswered.as_mut()?)
    }

    pub(crate) fn all_seen(&mut self) {
        self.unanswered = None;
    }

    pub(crate) fn limit(&self) -> Span {
        self.premise.limit
    }

    /// The text of `a`, if it was true at no moment at which `b` was known.
    pub(crate) fn never_asked(self) -> Option<String> {
        self.answered.map(|_| self.premise.text)
    }
}

fn true_from(evaluator: &mut Evaluator) -> Option<Stretch> {
    std::iter::from_fn(|| evaluator.take()).find(|stretch| stretch.truth.holds() == Some(true))
}
