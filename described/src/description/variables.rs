//! The variables of a device, each in a slot: time, parameters, states, states one step before, machines, and the
//! signals of received messages.

use super::arrays::{Arrays, Family};
use crate::hint;
use crate::layout::{Layout, Sender};
use crate::lookup::Lookup;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The slot of the part of an answer being sent, from 1.
pub(crate) const PART: usize = 1;

/// Number of slots before those of the parameters.
const FIXED: usize = 2;

#[derive(Debug, Clone)]
pub(super) struct MachineNames {
    pub(super) name: String,
    pub(super) states: Vec<String>,
}

/// Named items besides parameters and states.
#[derive(Debug, Clone, Default)]
pub(super) struct Named {
    pub(super) machines: Vec<MachineNames>,
    pub(super) tables: BTreeMap<String, Arc<Lookup>>,
    pub(super) parameter_arrays: Vec<Family>,
    pub(super) state_arrays: Vec<Family>,
}

/// Maps names to slots.
#[derive(Debug, Clone)]
pub(crate) struct Variables {
    pub(super) parameters: Vec<String>,
    pub(super) states: Vec<String>,
    pub(super) machines: Vec<MachineNames>,
    pub(super) tables: BTreeMap<String, Arc<Lookup>>,
    pub(super) arrays: Arrays,
    pub(super) layout: Layout,
    /// The first slot of each received message.
    heard: Vec<Option<usize>>,
    count: usize,
}

impl Variables {
    pub(super) fn new(
        parameters: Vec<String>,
        states: Vec<String>,
        named: Named,
        layout: Layout,
    ) -> Self {
        let Named { machines, tables, parameter_arrays, state_arrays } = named;
        let mut count = FIXED + parameters.len() + 2 * states.len() + 2 * machines.len();
        let mut slots = |message: &crate::layout::Message| {
            let first = count;
            count += message.signals.len();
            first
        };
        let heard = layout.messages().iter();
        let heard = heard.map(|message| (message.sender == Sender::Host).then(|| slots(message)));
        let heard = heard.collect();
        let first_state = FIXED + parameters.len();
        let arrays = Arrays::new(
            (&parameter_arrays, FIXED),
            (&state_arrays, first_state, first_state + states.len()),
        );
        Self { parameters, states, machines, tables, arrays, layout, heard, count }
    }

    pub(crate) fn states(&self) -> impl Iterator<Item = &str> {
        let machines = self.machines.iter().map(|machine| machine.name.as_str());
        self.states.iter().map(String::as_str).chain(machines)
    }

    /// The names of states and of arrays of them.
    pub(super) fn state_names(&self) -> Vec<String> {
        self.arrays.of_states().chain(self.states.iter().cloned()).collect()
    }

    pub(crate) const fn count(&self) -> usize {
        self.count
    }

    pub(crate) const fn parameter(&self, index: usize) -> usize {
        FIXED + index
    }

    pub(crate) const fn state(&self, index: usize) -> usize {
        FIXED + self.parameters.len() + index
    }

    /// The slot of a state at the end of the previous step.
    pub(crate) const fn last_state(&self, index: usize) -> usize {
        self.state(index) + self.states.len()
    }

    /// The slot of a machine's current state, by the index of the machine.
    pub(crate) const fn machine(&self, index: usize) -> usize {
        self.last_state(self.states.len()) + index
    }

    /// The slot of the time at which a machine entered its state.
    pub(crate) const fn entered(&self, index: usize) -> usize {
        self.machine(index) + self.machines.len()
    }

    pub(crate) fn signal(&self, message: usize, signal: usize) -> Option<usize> {
        self.heard.get(message).copied().flatten().map(|first| first + signal)
    }

    /// The slot of a parameter, a state or a machine.
    pub(crate) fn inner(&self, name: &str) -> Option<usize> {
        let place = |names: &[String]| names.iter().position(|known| known == name);
        let machine = || self.machines.iter().position(|known| known.name == name);
        place(&self.parameters)
            .map(|index| self.parameter(index))
            .or_else(|| place(&self.states).map(|index| self.state(index)))
            .or_else(|| machine().map(|index| self.machine(index)))
    }

    /// The index of the state in this slot.
    pub(super) fn state_in(&self, slot: usize) -> Option<usize> {
        slot.checked_sub(self.state(0)).filter(|index| *index < self.states.len())
    }

    /// True if the slot holds a state of the previous step.
    pub(super) fn is_last(&self, slot: usize) -> bool {
        (self.last_state(0)..self.last_state(self.states.len())).contains(&slot)
    }

    /// Message and help for an unknown name.
    pub(super) fn unknown(&self, name: &str) -> (String, String) {
        if self.layout.resolve_among(name, Some(Sender::Device)).is_ok() {
            let help = "write the states and parameters that it shows".to_owned();
            return (format!("`{name}` is sent, not heard"), help);
        }
        let inner = self.parameters.iter().chain(&self.states).cloned();
        let machines = self.machines.iter().map(|machine| machine.name.clone());
        let inner = inner.chain(machines).chain(self.tables.keys().cloned());
        let signals = self.layout.known(name.contains('.'), Some(Sender::Host));
        let known: Vec<String> = self.arrays.names().chain(inner).chain(signals).collect();
        (format!("no variable `{name}`"), hint::proposal(name, &known))
    }
}
