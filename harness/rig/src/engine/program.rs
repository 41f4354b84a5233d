//! Position of the engine in the plan: steps within repeats within sweeps.

use super::observe::Tags;
use plan::quantities::during_tag;
use plan::{Action, Order, Plan, Step};
use std::sync::Arc;
use wire::time::Timestamp;

/// One level of nesting: index of the step in its list, and round of the list.
#[derive(Debug, Clone, PartialEq)]
struct Level {
    index: usize,
    /// Completed rounds of this list.
    round: u64,
    /// When this round began.
    began: Timestamp,
    /// Deadline of the step that holds this list.
    deadline: Timestamp,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Next {
    /// A step that holds no others.
    Step(Box<Step>),
    Round {
        /// Value that a sweep sets.
        set: Option<Order>,
        /// The round may not begin earlier.
        not_before: Timestamp,
        /// By how much the previous round exceeded its period, s; for a repeat with a period.
        overrun_s: Option<f64>,
    },
    Done,
}

/// Position in the plan.
#[derive(Debug, Clone)]
pub struct Program {
    plan: Arc<Plan>,
    levels: Vec<Level>,
    done: u64,
    total: u64,
}

impl Program {
    /// Starts at the first step of `plan`, which must be done by `deadline`.
    pub fn new(plan: Arc<Plan>, now: Timestamp, deadline: Timestamp) -> Self {
        let total = leaves(&plan.steps);
        let level = Level { index: 0, round: 0, began: now, deadline };
        Self { plan, levels: vec![level], done: 0, total }
    }

    /// Steps done and steps in all, repetitions counted.
    pub const fn progress(&self) -> (u64, u64) {
        (self.done, self.total)
    }

    /// The step list of the innermost level.
    fn list(&self) -> &[Step] {
        let outer = &self.levels[..self.levels.len() - 1];
        outer.iter().fold(self.plan.steps.as_slice(), |steps, level| {
            steps.get(level.index).map_or(&[], |step| step.action.steps())
        })
    }

    /// The current step of the innermost level.
    fn here(&self) -> Option<&Step> {
        self.list().get(self.levels.last()?.index)
    }

    /// Repeats and sweeps around the current step, outermost first, each with its round.
    pub fn around(&self) -> Vec<(&Step, u64)> {
        let mut steps = self.plan.steps.as_slice();
        let mut around = Vec::new();
        for pair in self.levels.windows(2) {
            if let Some(step) = steps.get(pair[0].index) {
                around.push((step, pair[1].round));
                steps = step.action.steps();
            }
        }
        around
    }

    /// The current step and those around it, outermost first, each with a place that no other step or round shares.
    pub fn phases(&self) -> Vec<(Vec<(usize, u64)>, &Step)> {
        let place = |depth: usize| -> Vec<(usize, u64)> {
            self.levels.iter().take(depth).map(|level| (level.index, level.round)).collect()
        };
        let around = self.around().into_iter().enumerate().map(|(depth, (step, round))| {
            let mut place = place(depth + 1);
            place.push((usize::MAX, round));
            (place, step)
        });
        around.chain(self.here().map(|step| (place(self.levels.len()), step))).collect()
    }

    /// The current step as named in messages: `steps[2].repeat[0] (round 7 of 40)`.
    pub fn place(&self) -> String {
        let mut place = String::from("steps");
        for (depth, level) in self.levels.iter().enumerate() {
            place.push_str(&format!("[{}]", level.index));
            if depth + 1 < self.levels.len()
                && let Some((step, _)) = self.around().get(depth)
            {
                place.push_str(&format!(".{}", step.action.name()));
            }
        }
        if let Some((step, round)) = self.around().last() {
            let rounds = step.action.repetitions();
            place.push_str(&format!(" (round {} of {rounds})", round + 1));
        }
        place
    }

    /// Tags of what is observed during `step`: the step, those around it, and the values of sweeps. `rounds` counts the
    /// rounds of the innermost repeats and sweeps so far.
    pub fn tags(&self, step: &Action, label: Option<&str>, rounds: u64) -> Tags {
        let mut tags = Tags::new();
        let mut during = vec![step.name().to_owned()];
        during.extend(label.map(str::to_owned));
        for (step, round) in self.around() {
            during.push(step.action.name().to_owned());
            during.extend(step.label.as_ref().map(|label| label.as_str().to_owned()));
            if let Action::Sweep(sweep) = &step.action
                && let Some(value) = sweep.values.get(round as usize)
            {
                tags.insert(sweep.parameter.to_string(), *value);
            }
        }
        // Rounds keep counting when a repeat begins anew, so that no two share a number.
        tags.insert("run".to_owned(), rounds.max(1) as f64);
        tags.extend(during.iter().map(|phase| (during_tag(phase), 1.0)));
        tags
    }

    /// The earliest deadline of the repeats and sweeps around the current step.
    pub fn deadline(&self) -> Timestamp {
        self.levels.iter().map(|level| level.deadline).min().unwrap_or(Timestamp::MAX)
    }

    pub fn step_done(&mut self) {
        self.done += 1;
        if let Some(level) = self.levels.last_mut() {
            level.index += 1;
        }
    }

    /// Returns what comes next. `holds` evaluates the condition that ends a repeat.
    pub fn next(&mut self, now: Timestamp, holds: impl Fn(&Action) -> bool) -> Next {
        loop {
            if let Some(step) = self.here() {
                if step.action.steps().is_empty() {
                    return Next::Step(Box::new(step.clone()));
                }
                if holds(&step.action) {
                    self.skip(0);
                    continue;
                }
                let deadline = now + step.time_limit();
                let set = swept(&step.action, 0);
                self.levels.push(Level { index: 0, round: 0, began: now, deadline });
                return Next::Round { set, not_before: now, overrun_s: None };
            }
            // The end of a list.
            if self.levels.len() == 1 {
                return Next::Done;
            }
            let Some(inner) = self.levels.pop() else { return Next::Done };
            let Some(step) = self.here() else { return Next::Done };
            let round = inner.round + 1;
            if round >= step.action.repetitions() || holds(&step.action) {
                self.skip(round);
                continue;
            }
            let set = swept(&step.action, round);
            let (not_before, overrun_s) = match &step.action {
                Action::Repeat(repeat) => repeat.period.map_or((now, None), |period| {
                    let due = inner.began + period;
                    (due.max(now), Some((now - due).as_secs_f64().max(0.0)))
                }),
                _ => (now, None),
            };
            self.levels.push(Level { index: 0, round, began: not_before, ..inner });
            return Next::Round { set, not_before, overrun_s };
        }
    }

    /// Leaves a repeat or a sweep after `rounds` rounds; the rounds left out count as done.
    fn skip(&mut self, rounds: u64) {
        if let Some(step) = self.here() {
            let left = step.action.repetitions().saturating_sub(rounds);
            self.done += left * leaves(step.action.steps());
        }
        if let Some(level) = self.levels.last_mut() {
            level.index += 1;
        }
    }
}

/// The order by which a sweep sets its value for that round.
fn swept(action: &Action, round: u64) -> Option<Order> {
    let Action::Sweep(sweep) = action else { return None };
    sweep.order(usize::try_from(round).ok()?)
}

/// Number of steps that hold no others, repetitions counted.
fn leaves(steps: &[Step]) -> u64 {
    steps
        .iter()
        .map(|step| match step.action.steps() {
            [] => 1,
            inner => step.action.repetitions().saturating_mul(leaves(inner)),
        })
        .fold(0, u64::saturating_add)
}
