//! Answers that wait for their time, and questions that wait for answers.

use super::{Device, dynamics::finite};
use crate::description::{Answer, Model, WhileAnswering};
use std::collections::VecDeque;
use wire::time::Timestamp;

/// Answers that wait for their delay; what comes on top is dropped and counted.
pub(super) const ANSWERS_MAX: usize = 64;

/// An answer, or what is left of one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Waiting {
    /// When its next message is sent.
    pub(super) at: Timestamp,
    /// Its place among the messages that are sent.
    pub(super) sent: usize,
    /// Which message of it that is, from 1, and how many there are.
    pub(super) part: u32,
    parts: u32,
    /// It is to a question that others wait for.
    holds: bool,
}

/// What a device has been asked.
#[derive(Debug, Clone, Default)]
pub(super) struct Answers {
    waiting: VecDeque<Waiting>,
    /// Questions that are heard once those before them have been answered: the place of the message, and its values.
    questions: VecDeque<(usize, Vec<Option<f64>>)>,
    /// Questions that were refused because another was being answered.
    pub(super) refused: u64,
    /// Answers that had no room.
    pub(super) dropped: u64,
}

impl Answers {
    pub(super) fn clear(&mut self) {
        self.waiting.clear();
        self.questions.clear();
    }

    /// When each is due.
    pub(super) fn times(&self) -> impl Iterator<Item = Timestamp> {
        self.waiting.iter().map(|waiting| waiting.at)
    }

    /// The earliest that is due, of several the first, and its place.
    #[inline]
    pub(super) fn due(&self, now: Timestamp) -> Option<(Timestamp, usize)> {
        if self.waiting.is_empty() {
            return None;
        }
        let times = self.waiting.iter().enumerate().map(|(place, waiting)| (waiting.at, place));
        times.filter(|(at, _)| *at <= now && *at != super::NEVER).min()
    }

    /// The next message of the answer at this place; what is left of it waits on.
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

    /// The question whose turn it is.
    pub(super) fn question(&mut self) -> Option<(usize, Vec<Option<f64>>)> {
        if self.questions.is_empty() || self.is_busy() {
            return None;
        }
        self.questions.pop_front()
    }
}

impl Device {
    /// Whether a message that came is used now: else it waits, or is refused.
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

    /// Has the answers to a message wait for their time: those to one that is used, or those to one that is refused.
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

    /// Of how many messages an answer is; none where it is not one to this question.
    fn parts(&mut self, answer: &Answer) -> Option<u32> {
        let values = self.dynamics.values();
        if let Some(when) = &answer.when
            && finite(when.value(values), 0.0, &mut self.not_finite) == 0.0
        {
            return None;
        }
        let Some((times, _)) = &answer.times else { return Some(1) };
        let times = finite(times.value(values), 0.0, &mut self.not_finite);
        // What is below 1 is none, and a fraction of a message is not sent.
        let times = times.clamp(0.0, crate::description::TIMES_MAX) as u32;
        (times > 0).then_some(times)
    }
}
