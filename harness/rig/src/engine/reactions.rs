//! How long nodes take from one condition to another, as the plan defines reactions.

use super::observe::{Tags, Took};
use described::Decoded;
use plan::quantities::REACTION_PREFIX;
use plan::{Plan, Reads, Speaker, formula};
use std::collections::VecDeque;
use temporal::Reaction;
use wire::time::{Span, Timestamp};

/// Most stimuli of a reaction that wait for their answer.
const WAITING_MAX: usize = 10_000;

/// Most moments at which the harness was late that are kept, the last ones.
const LATE_MAX: usize = 1_000;

/// Below this the harness was in time. Assumption: a tenth of the shortest times that are measured in real time.
const LATE_MIN: Span = Span::from_millis(1);

/// A bound divided by its standard uncertainty, for a uniform distribution up to it.
const BOUND_OVER_U: f64 = 1.732_050_807_568_877_2;

/// The reactions that a measurement or a step of the plan uses.
#[derive(Debug, Clone, Default)]
pub(super) struct Reactions {
    each: Vec<(String, Reaction)>,
    late: Late,
    reads: Reads,
    awaited: Option<Awaited>,
    /// The steps during which stimuli came that still wait, the last one always: when each began, and its tags.
    steps: VecDeque<(Timestamp, Tags)>,
}

/// When the harness was late in real time, and by how much.
#[derive(Debug, Clone, Default)]
struct Late(VecDeque<(Timestamp, Span)>);

impl Late {
    /// Standard uncertainty of the time between what was heard at these moments, s: each may have come earlier, by as much as
    /// the harness was late then. What had to wait meanwhile is heard within as long a time after it.
    fn uncertainty(&self, moments: [Timestamp; 2]) -> f64 {
        let is_near = |(then, by): &&(Timestamp, Span)| {
            moments.iter().any(|at| *at >= *then && *at - *then <= *by)
        };
        let bound = self.0.iter().filter(is_near).map(|(_, by)| *by).max();
        bound.map_or(0.0, |bound| bound.as_secs_f64() / BOUND_OVER_U)
    }
}

#[derive(Debug, Clone)]
struct Awaited {
    quantity: String,
    /// Earlier stimuli do not count.
    since: Timestamp,
    until: Timestamp,
    /// When the answer is certain, if no signal changes until then.
    due: Timestamp,
    has_come: bool,
}

impl Reactions {
    /// The reactions of `plan` on a rig with these speakers.
    pub(super) fn of(plan: &Plan, speakers: &[Speaker]) -> Self {
        let read = |text: &str| formula(text, speakers).ok();
        let mut formulas = Vec::new();
        let mut each = Vec::new();
        for declared in &plan.reactions {
            let (Some(from), Some(to)) = (read(&declared.from), read(&declared.to)) else {
                continue;
            };
            let quantity = format!("{REACTION_PREFIX}{}", declared.name);
            each.push((quantity, Reaction::new(&from, &to, WAITING_MAX)));
            formulas.extend([from, to]);
        }
        let reads = Reads::of(&formulas, speakers);
        Self { each, reads, late: Late::default(), awaited: None, steps: VecDeque::new() }
    }

    /// The harness was late at `then`, by this time.
    pub(super) fn heard_late(&mut self, then: Timestamp, by: Span) {
        if self.each.is_empty() || by < LATE_MIN {
            return;
        }
        if self.late.0.len() == LATE_MAX {
            self.late.0.pop_front();
        }
        self.late.0.push_back((then, by));
    }

    /// Waits from now on, and no longer than to the end of `until`, for the first answer to a stimulus of the reaction
    /// `name`.
    pub(super) fn await_one(&mut self, name: &str, now: Timestamp, until: Timestamp) {
        let quantity = format!("{REACTION_PREFIX}{name}");
        let (since, due) = (now, Timestamp::MAX);
        self.awaited = Some(Awaited { quantity, since, until, due, has_come: false });
        self.foresee();
    }

    /// When the awaited answer is certain, if no signal changes until then.
    pub(super) fn due(&self) -> Timestamp {
        self.awaited.as_ref().map_or(Timestamp::MAX, |awaited| awaited.due)
    }

    fn foresee(&mut self) {
        let Some(awaited) = self.awaited.as_mut().filter(|awaited| !awaited.has_come) else {
            return;
        };
        let reaction = self.each.iter().find(|(quantity, _)| *quantity == awaited.quantity);
        let due = reaction.and_then(|(_, one)| one.due(awaited.since, after(awaited.until)));
        awaited.due = due.unwrap_or(Timestamp::MAX);
    }

    /// Whether the awaited answer has come.
    pub(super) fn has_come(&self) -> bool {
        self.awaited.as_ref().is_some_and(|awaited| awaited.has_come)
    }

    /// Whether the awaited stimulus has come and is still without an answer.
    pub(super) fn is_asked(&self) -> bool {
        let Some(awaited) = &self.awaited else { return false };
        let reaction = self.each.iter().find(|(quantity, _)| *quantity == awaited.quantity);
        reaction.is_some_and(|(_, one)| one.waiting().any(|asked| asked >= awaited.since))
    }

    /// A step begins, whose observations have these tags.
    pub(super) fn step_began(&mut self, now: Timestamp, tags: &Tags) {
        if self.each.is_empty() {
            return;
        }
        let oldest = self.each.iter().filter_map(|(_, one)| one.waiting().next()).min();
        let oldest = oldest.unwrap_or(now);
        while self.steps.get(1).is_some_and(|(began, _)| *began <= oldest) {
            self.steps.pop_front();
        }
        self.steps.push_back((now, tags.clone()));
    }

    /// Takes a message of a speaker. Returns the reaction times that it completes.
    pub(super) fn take(
        &mut self,
        now: Timestamp,
        speaker: usize,
        decoded: &Decoded<'_>,
    ) -> Vec<Took> {
        let Some((now, values)) = self.reads.take(now, speaker, decoded) else {
            return Vec::new();
        };
        let each = self.each.iter_mut();
        each.for_each(|(_, reaction)| reaction.update(now, values));
        let answers = self.answers();
        self.foresee();
        answers
    }

    /// Time has passed without a message. Returns the reaction times that are certain now.
    pub(super) fn pass_time(&mut self, now: Timestamp) -> Vec<Took> {
        let Some(awaited) = &self.awaited else { return Vec::new() };
        // What has come by its limit is in time.
        let to = if now >= awaited.until { after(now) } else { now };
        self.each.iter_mut().for_each(|(_, reaction)| reaction.advance(to));
        let answers = self.answers();
        self.foresee();
        answers
    }

    /// Ends the run: returns the answers by now and how long the open stimuli have waited.
    pub(super) fn finish(&mut self, now: Timestamp) -> Vec<Took> {
        self.each.iter_mut().for_each(|(_, reaction)| reaction.finish(now));
        let mut answers = self.answers();
        for (quantity, reaction) in &self.each {
            answers.extend(reaction.waiting().map(|asked| Took {
                quantity: quantity.clone(),
                seconds: (now.max(asked) - asked).as_secs_f64(),
                uncertainty: self.late.uncertainty([asked, now.max(asked)]),
                tags: tags_at(&self.steps, asked),
                is_open: true,
            }));
        }
        self.each.clear();
        answers
    }

    fn answers(&mut self) -> Vec<Took> {
        let mut answers = Vec::new();
        for (quantity, reaction) in &mut self.each {
            while let Some(answer) = reaction.take() {
                if let Some(awaited) = &mut self.awaited {
                    let is_it = *quantity == awaited.quantity && answer.asked >= awaited.since;
                    awaited.has_come |= is_it;
                    awaited.due = if awaited.has_come { Timestamp::MAX } else { awaited.due };
                }
                answers.push(Took {
                    quantity: quantity.clone(),
                    seconds: answer.after.as_secs_f64(),
                    uncertainty: self.late.uncertainty([answer.asked, answer.asked + answer.after]),
                    tags: tags_at(&self.steps, answer.asked),
                    is_open: false,
                });
            }
        }
        answers
    }
}

fn after(moment: Timestamp) -> Timestamp {
    moment + Span::from_nanos(1)
}

fn tags_at(steps: &VecDeque<(Timestamp, Tags)>, asked: Timestamp) -> Tags {
    let step = steps.iter().rev().find(|(began, _)| *began <= asked).or(steps.front());
    step.map(|(_, tags)| tags.clone()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::{Late, Span, Timestamp};

    /// Found by a user: a harness that was 82 ms late told a reaction of 158 ms as 44 ms, without any uncertainty.
    #[test]
    fn what_was_heard_late_is_uncertain() {
        let at = |ms: i64| Timestamp::from_nanos(ms * 1_000_000);
        let late = Late([(at(1_000), Span::from_millis(90))].into());
        let bound_ms = |from: i64, to: i64| {
            (late.uncertainty([at(from), at(to)]) * 1e3 * super::BOUND_OVER_U).round()
        };
        assert_eq!(bound_ms(1_000, 1_044), 90.0, "the first, of which the second had to wait, too");
        assert_eq!(bound_ms(500, 1_001), 90.0, "the answer alone");
        assert_eq!(bound_ms(500, 999), 0.0, "before");
        assert_eq!(bound_ms(500, 2_000), 0.0, "between them nothing depends on it");
    }
}
