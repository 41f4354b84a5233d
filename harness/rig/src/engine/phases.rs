//! Reports when phases of the plan begin and end, for a plan whose faults wait for them.

use super::{Action, Program};
use controller::mission::Command;
use plan::phases::{self, PhaseEvent};
use std::collections::VecDeque;

/// Place of a level in the plan: index of the step in each list, and its round.
type Place = Vec<(usize, u64)>;

/// The phases that are open, outermost first.
#[derive(Debug, Clone, Default)]
pub(super) struct Phases {
    /// False without faults: nothing waits for a phase.
    watched: bool,
    open: Vec<(Place, Vec<String>)>,
    mission: Option<&'static str>,
}

impl Phases {
    pub(super) fn new(watched: bool) -> Self {
        Self { watched, ..Self::default() }
    }

    /// Faults may be added later that wait for phases.
    pub(super) const fn watch(&mut self) {
        self.watched = true;
    }

    /// A step of the program begins.
    pub(super) fn step_began(&mut self, program: &Program, actions: &mut VecDeque<Action>) {
        if !self.watched {
            return;
        }
        let here = program.phases();
        let same = here.iter().zip(&self.open).take_while(|(here, open)| here.0 == open.0).count();
        self.close(same, actions);
        for (place, step) in here.into_iter().skip(same) {
            let names: Vec<String> = phases::names(step).map(str::to_owned).collect();
            actions.extend(names.iter().cloned().map(PhaseEvent::Began).map(Action::Phase));
            self.open.push((place, names));
        }
    }

    /// The step ends; the repeats around it may go on.
    pub(super) fn step_ended(&mut self, actions: &mut VecDeque<Action>) {
        self.mission_ended(actions);
        self.close(self.open.len().saturating_sub(1), actions);
    }

    /// The plan ends.
    pub(super) fn all_ended(&mut self, actions: &mut VecDeque<Action>) {
        self.mission_ended(actions);
        self.close(0, actions);
        actions.extend(self.watched.then_some(Action::Phase(PhaseEvent::PlanEnded)));
    }

    /// The controller receives a command.
    pub(super) fn mission_began(&mut self, command: &Command, actions: &mut VecDeque<Action>) {
        if !self.watched {
            return;
        }
        self.mission = phases::of_command(command);
        let began = self.mission.map(|name| PhaseEvent::Began(name.to_owned()));
        actions.extend(began.map(Action::Phase));
    }

    /// The controller has answered.
    pub(super) fn mission_ended(&mut self, actions: &mut VecDeque<Action>) {
        let ended = self.mission.take().map(|name| PhaseEvent::Ended(name.to_owned()));
        actions.extend(ended.map(Action::Phase));
    }

    /// Ends all phases but the outermost `left`, innermost first.
    fn close(&mut self, left: usize, actions: &mut VecDeque<Action>) {
        for (_, names) in self.open.drain(left..).rev() {
            actions.extend(names.into_iter().rev().map(PhaseEvent::Ended).map(Action::Phase));
        }
    }
}
