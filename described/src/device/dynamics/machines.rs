//! Execution of state machines.

use super::Dynamics;
use super::laws::{Moment, finite};
use crate::description::{Machine, Model, Setting};
use crate::device::NEVER;
use wire::time::Timestamp;

/// State of the machines beside their variables.
#[derive(Debug, Clone, Default)]
pub(super) struct Machines {
    entered: Vec<Timestamp>,
    /// The next time at which a machine's time in its state matters; `None` for never.
    pub(super) deadline: Option<Timestamp>,
    /// Pending assignments, by slot.
    settings: Vec<(usize, f64)>,
}

impl Dynamics {
    /// Power-on.
    pub(super) fn start_machines(&mut self, model: &Model, now: Timestamp) {
        self.machines.entered.clear();
        self.machines.entered.resize(model.machines.len(), now);
        for (index, machine) in model.machines.iter().enumerate() {
            self.values[model.variables.machine(index)] = machine.start as f64;
            self.values[model.variables.entered(index)] = 0.0;
        }
        self.plan(model, now);
    }

    /// The next time at which a machine's time in its state matters.
    pub(in crate::device) fn deadline(&self) -> Timestamp {
        self.machines.deadline.unwrap_or(NEVER)
    }

    /// Makes at most one transition per machine: the first possible one in the order of the file.
    pub(in crate::device) fn go_on(&mut self, model: &Model, now: Timestamp, heard: Option<usize>) {
        let mut has_changed = false;
        for (index, machine) in model.machines.iter().enumerate() {
            let Some(place) = self.transition(model, (index, machine), now, heard) else {
                continue;
            };
            let transition = &machine.transitions[place];
            self.apply(&transition.set);
            self.values[model.variables.machine(index)] = transition.to as f64;
            self.values[model.variables.entered(index)] = self.seconds(now);
            self.machines.entered[index] = now;
            self.apply(&machine.enter[transition.to]);
            // The next machine sees the result.
            self.laws.follow(&mut self.values, Moment::WithinStep, &mut self.not_finite);
            has_changed = true;
        }
        if has_changed {
            self.laws.remember(&mut self.values);
            self.has_changed();
        }
        if has_changed || self.machines.deadline.is_some_and(|at| at <= now) {
            self.plan(model, now);
        }
        if !self.monitors.is_empty() {
            self.test_codes(model, now);
        }
        self.look_at_inputs(model);
    }

    fn transition(
        &mut self,
        model: &Model,
        (index, machine): (usize, &Machine),
        now: Timestamp,
        heard: Option<usize>,
    ) -> Option<usize> {
        let state = self.values[model.variables.machine(index)] as usize;
        let entered = self.machines.entered[index];
        let Self { values, not_finite, .. } = self;
        machine.transitions.iter().position(|one| {
            one.from[state]
                && (one.on.is_none() || one.on == heard)
                && one.after.is_none_or(|after| entered + after <= now)
                && one
                    .when
                    .as_ref()
                    .is_none_or(|when| finite(when.value(values), 0.0, not_finite) != 0.0)
        })
    }

    /// Evaluates all assignments on the old values, then assigns.
    fn apply(&mut self, settings: &[Setting]) {
        let mut worked_out = std::mem::take(&mut self.machines.settings);
        worked_out.clear();
        for Setting { slot, value } in settings {
            let value = value.value(&self.values);
            worked_out.push((*slot, finite(value, self.values[*slot], &mut self.not_finite)));
        }
        for (slot, value) in &worked_out {
            self.values[*slot] = *value;
        }
        self.machines.settings = worked_out;
    }

    /// Computes the next time at which a transition may be due to time alone.
    pub(super) fn plan(&mut self, model: &Model, now: Timestamp) {
        let each = model.machines.iter().zip(&self.machines.entered).enumerate();
        let times = each.flat_map(|(index, (machine, entered))| {
            let state = self.values[model.variables.machine(index)] as usize;
            let waits =
                machine.transitions.iter().filter(move |one| one.from[state] && one.on.is_none());
            waits.filter_map(|one| one.after).map(|after| *entered + after)
        });
        self.machines.deadline = times.filter(|at| *at > now).min();
    }
}
