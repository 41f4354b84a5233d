//! Phases of a plan: what can be waited for by name while it runs.
//!
//! A phase is a step, by its key or its label, or one round of a repeat or a sweep. Turns, straights and
//! bias tests are counted by what the controller is told, so that a lap holds four turns.

use super::step::{Action, Step};
use super::{Name, Plan};
use controller::mission::Command;
use std::collections::BTreeMap;

/// A phase began or ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PhaseEvent {
    /// The phase of this name began.
    Began(String),
    /// The phase of this name ended; of several of one name the one that began last.
    Ended(String),
}

/// The phase that a command to the controller is, where it is one.
pub const fn of_command(command: &Command) -> Option<&'static str> {
    match command {
        Command::Turn(_) => Some("turn"),
        Command::Straight(_) => Some("straight"),
        Command::BiasTest(_) => Some("bias_test"),
        _ => None,
    }
}

/// The phases that the controller is told within a step, and how many.
pub(super) const fn told(action: &Action) -> &'static [(&'static str, u64)] {
    match action {
        Action::Turn(_) => &[("turn", 1)],
        Action::Straight(_) => &[("straight", 1)],
        Action::BiasTest(_) => &[("bias_test", 1)],
        Action::Lap(_) => &[("straight", 4), ("turn", 4)],
        _ => &[],
    }
}

/// The names of the phase that a step, or a round of it, is.
pub fn names(step: &Step) -> impl Iterator<Item = &str> {
    let name = step.action.name();
    let told_by_this_name = told(&step.action).iter().any(|(told, _)| *told == name);
    let own = (!told_by_this_name).then_some(name);
    own.into_iter().chain(step.label.as_ref().map(Name::as_str))
}

impl Plan {
    /// How often each phase comes, at most: a repeat may end early.
    pub fn phases(&self) -> BTreeMap<&str, u64> {
        let mut counts = BTreeMap::new();
        count(&self.steps, 1, &mut counts);
        counts
    }
}

fn count<'a>(steps: &'a [Step], rounds: u64, counts: &mut BTreeMap<&'a str, u64>) {
    for step in steps {
        let rounds = rounds.saturating_mul(step.action.repetitions());
        let mut add = |name: &'a str, times: u64| {
            let sum = counts.entry(name).or_default();
            *sum = sum.saturating_add(rounds.saturating_mul(times));
        };
        names(step).for_each(|name| add(name, 1));
        told(&step.action).iter().for_each(|(name, times)| add(name, *times));
        count(step.action.steps(), rounds, counts);
    }
}
