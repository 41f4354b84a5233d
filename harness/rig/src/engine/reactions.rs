//! How long nodes take from one condition to another, as the plan defines reactions.

use described::Decoded;
use plan::quantities::REACTION_PREFIX;
use plan::{Plan, Reads, Speaker, formula};
use temporal::Reaction;
use wire::time::Timestamp;

/// Most stimuli of a reaction that wait for their answer.
const WAITING_MAX: usize = 10_000;

/// The reactions that a measurement or a step of the plan uses.
#[derive(Debug, Clone, Default)]
pub(super) struct Reactions {
    each: Vec<(String, Reaction)>,
    reads: Reads,
    awaited: Option<Awaited>,
}

#[derive(Debug, Clone)]
struct Awaited {
    quantity: String,
    /// Earlier stimuli do not count.
    since: Timestamp,
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
        Self { each, reads: Reads::of(&formulas, speakers), awaited: None }
    }

    /// Waits from now on for the first answer to a stimulus of the reaction `name`.
    pub(super) fn await_one(&mut self, name: &str, now: Timestamp) {
        let quantity = format!("{REACTION_PREFIX}{name}");
        self.awaited = Some(Awaited { quantity, since: now, has_come: false });
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

    /// Takes a message of a speaker. Returns the reaction times that it completes, by quantity, in s.
    pub(super) fn take(
        &mut self,
        now: Timestamp,
        speaker: usize,
        decoded: &Decoded<'_>,
    ) -> Vec<(String, f64)> {
        let Some(values) = self.reads.take(speaker, decoded) else { return Vec::new() };
        let each = self.each.iter_mut();
        each.for_each(|(_, reaction)| reaction.update(now, values));
        self.answers()
    }

    /// Ends the run: returns the answers by now and how long the open stimuli have waited, by quantity, in s.
    pub(super) fn finish(&mut self, now: Timestamp) -> Vec<(String, f64)> {
        self.each.iter_mut().for_each(|(_, reaction)| reaction.finish(now));
        let mut answers = self.answers();
        for (quantity, reaction) in &self.each {
            let waited = reaction.waiting().map(|asked| (now - asked).as_secs_f64());
            answers.extend(waited.map(|waited| (quantity.clone(), waited)));
        }
        self.each.clear();
        answers
    }

    fn answers(&mut self) -> Vec<(String, f64)> {
        let mut answers = Vec::new();
        for (quantity, reaction) in &mut self.each {
            while let Some(answer) = reaction.take() {
                if let Some(awaited) = &mut self.awaited {
                    let is_it = *quantity == awaited.quantity && answer.asked >= awaited.since;
                    awaited.has_come |= is_it;
                }
                answers.push((quantity.clone(), answer.after.as_secs_f64()));
            }
        }
        answers
    }
}
