//! Moments that cannot be judged because a reading is NaN or infinite.

use crate::evaluator::{Evaluator, Stretch};
use std::collections::VecDeque;
use wire::time::Timestamp;

/// Follows a formula with the last finite value of each signal in place of a reading that is not finite. Where that is
/// known and the formula is not, the reading alone keeps it from being judged.
#[derive(Debug, Clone)]
pub(crate) struct NotFinite {
    finite: Evaluator,
    /// The next final stretch of `finite`.
    next: Option<Stretch>,
    /// Final stretches of the formula itself that `finite` has not reached.
    judged: VecDeque<Stretch>,
    /// The signals with such readings, by the caller's number, and the first reading of each.
    readings: Vec<(usize, f64)>,
}

impl NotFinite {
    /// Follows a formula that had finite readings so far.
    pub(crate) fn beside(evaluator: &Evaluator) -> Self {
        let mut finite = evaluator.clone();
        finite.history = None;
        Self { finite, next: None, judged: VecDeque::new(), readings: Vec::new() }
    }

    pub(crate) fn update(&mut self, time: Timestamp, values: &[(usize, f64)]) {
        let mut finite = values.to_vec();
        for (index, value) in finite.iter_mut().filter(|(_, value)| !value.is_finite()) {
            let Some(last) = self.finite.value(*index) else { continue };
            if self.readings.iter().all(|(known, _)| known != index) {
                self.readings.push((*index, *value));
            }
            // Without a value so far, any number will do.
            *value = if last.is_nan() { 0.0 } else { last };
        }
        self.finite.update(time, &finite);
    }

    pub(crate) fn follow(&mut self, to: impl FnOnce(&mut Evaluator)) {
        to(&mut self.finite);
    }

    /// Takes the next final stretch of the formula.
    pub(crate) fn judged(&mut self, stretch: Stretch) {
        self.judged.push_back(stretch);
    }

    /// The first moment that is unknown for such a reading alone, as far as final.
    pub(crate) fn first(&mut self) -> Option<Timestamp> {
        loop {
            self.next = self.next.or_else(|| self.finite.take());
            let (judged, finite) = (*self.judged.front()?, self.next?);
            if finite.truth.is_known() && !judged.truth.is_known() {
                return Some(judged.from.max(finite.from));
            }
            let to = judged.to.min(finite.to);
            self.next = finite.behind(to);
            self.judged.pop_front();
            judged.behind(to).into_iter().for_each(|rest| self.judged.push_front(rest));
        }
    }

    pub(crate) fn readings(&self) -> &[(usize, f64)] {
        &self.readings
    }
}
