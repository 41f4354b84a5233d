//! Answers waiting for their time, and questions waiting for answers.

use super::{Device, dynamics::finite};
use crate::description::{Answer, Model, WhileAnswering};
use std::collections::VecDeque;
use wire::time::Timestamp;

/// Maximum number of delayed answers; any more are dropped and counted.
pub(super) const ANSWERS_MAX: usize = 64;

#[derive(Debug, Clone, Copy)]
pub(super) struct Waiting {
    /// Time of its next message.
    pub(super) at: Timestamp,
    /// Its index among the sent messages.
    pub(super) sent: usize,
    /// The number of that message, from 1, and the total.
    pub(super) part: u32,
    parts: u32,
    /// Other questions wait for its end.
    holds: bool,
}

/// Pending questions and answers of a device.
#[derive(Debug, Clone, Default)]
pub(super) struct Answers {
    waiting: VecDeque<Waiting>,
    /// Questions that wait for the preceding answers: the index of the message, and its values.
    questions: VecDeque<(usize, Vec<Option<f64>>)>,
    /// Number of questions refused because another was being answered.
    pub(super) refused: u64,
    /// Number of answers dropped because the queue was full.
    pub(super) dropped: u64,
}

impl Answers {
    pub(super) fn clear(&mut self) {
        self.waiting.clear();
        self.questions.clear();
    }

    /// The due times.
    pub(super) fn times(&self) -> impl Iterator<Item = Timestamp> {
        self.waiting.iter().map(|waiting| waiting.at)
    }

    /// The earliest due answer, the first of several, and its position.
    #[inline]
    pub(super) fn due(&self, now: Timestamp) -> Option<(Timestamp, usize)> {
        if self.waiting.is_empty() {
            return None;
        }
        let times = self.waiting.iter().enumerate().map(|(place, waiting)| (waiting.at, place));
        times.filter(|(at, _)| *at <= now && *at != super::NEVER).min()
    }

    /// The next message of the answer at `place`; the rest of the answer keeps waiting.
    pub(super) fn next(&mut self, model: &Model, place: usize) -> Option<Waiting> {
        let next = self.waiting.remove(place)?;
        let every = model.sent[next.sent].answers.as_ref().and_then(|answer| answer.times.as_ref());
        if let (true, Some((_, every))) = (next.part < next.parts, every) {
            self.waiting.push_back(Waiting { at: next.at + *every, part: next.part + 1, ..next });
        }
        Some(next)
    }

    fn is_busy(&self) -> bool {
        self.waiting.iter().any(|waiting| waiting.holds)
    }

    /// The next question whose turn it is.
    pub(super) fn question(&mut self) -> Option<(usize, Vec<Option<f64>>)> {
        if self.questions.is_empty() || self.is_busy() {
            return None;
        }
        self.questions.pop_front()
    }
}

impl Device {
    /// True if an arriving message is used now; otherwise it waits or is refused.
    pub(super) fn accepts(
        &mut self,
        model: &Model,
        now: Timestamp,
        message: usize,
        values: &[Option<f64>],
    ) -> bool {
        let heard = model.heard.iter().find(|heard| heard.message == message);
        let Some(rule) = heard.and_then(|heard| heard.while_answering) else { return true };
        if !self.answers.is_busy() {
            return true;
        }
        match rule {
            WhileAnswering::Queue(length) if self.answers.questions.len() < length => {
                self.answers.questions.push_back((message, values.to_vec()));
            }
            WhileAnswering::Queue(_) | WhileAnswering::Refuse => {
                self.answers.refused += 1;
                self.answer(model, now, message, true);
            }
        }
        false
    }

    /// Schedules the answers to a used message, or to a refused one.
    pub(super) fn answer(&mut self, model: &Model, now: Timestamp, question: usize, busy: bool) {
        let heard = model.heard.iter().find(|heard| heard.message == question);
        let holds = !busy && heard.is_some_and(|heard| heard.while_answering.is_some());
        for (sent, rule) in model.sent.iter().enumerate() {
            let is_meant = |answer: &&Answer| answer.question == question && answer.busy == busy;
            let Some(answer) = rule.answers.as_ref().filter(is_meant) else { continue };
            let Some(parts) = self.parts(answer) else { continue };
            if self.answers.waiting.len() >= ANSWERS_MAX {
                self.answers.dropped += 1;
                continue;
            }
            let at = now + answer.delay;
            self.answers.waiting.push_back(Waiting { at, sent, part: 1, parts, holds });
        }
    }

    /// Number of messages of an answer; `None` if it is not an answer to this question.
    fn parts(&mut self, answer: &Answer) -> Option<u32> {
        let values = self.dynamics.values();
        if let Some(when) = &answer.when
            && finite(when.value(values), 0.0, &mut self.not_finite) == 0.0
        {
            return None;
        }
        let Some((times, _)) = &answer.times else { return Some(1) };
        let times = finite(times.value(values), 0.0, &mut self.not_finite);
        // Less than 1 means none; fractions are cut off.
        let times = times.clamp(0.0, crate::description::TIMES_MAX) as u32;
        (times > 0).then_some(times)
    }
}
