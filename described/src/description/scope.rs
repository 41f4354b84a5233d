//! Meaning of names in the expressions of a file.

use super::arrays::{INDEX, find};
use super::variables::{PART, Variables};
use crate::expression::{Meaning, Scope, States, TIME, Unknown};
use crate::hint;
use crate::layout::{Sender, SignalName};

/// The name of the current part of an answer, from 1.
const PART_NAME: &str = "part";

impl Scope for Variables {
    fn variable(&self, name: &str) -> Result<Meaning, Unknown> {
        if name == "t" {
            return Ok(Meaning::Slot(TIME));
        }
        if let Some(slot) = self.inner(name) {
            return Ok(Meaning::Slot(slot));
        }
        let arrays =
            find(&self.arrays.parameters, name).or_else(|| find(&self.arrays.states, name));
        let table = || self.tables.get(name).cloned().map(Meaning::Table);
        if let Some(meaning) = arrays.or_else(table) {
            return Ok(meaning);
        }
        match self.layout.resolve_among(name, Some(Sender::Host)) {
            Ok((message, signal)) => {
                let slot = self.signal(message, signal);
                slot.map(Meaning::Slot).ok_or_else(|| self.unknown(name))
            }
            Err(SignalName::Unknown { .. }) => Err(self.unknown(name)),
            Err(error) => Err((error.to_string(), error.advice().to_owned())),
        }
    }

    fn last(&self, name: &str) -> Result<Meaning, Unknown> {
        let found = self.states.iter().position(|known| known == name);
        found
            .map(|index| Meaning::Slot(self.last_state(index)))
            .or_else(|| find(&self.arrays.last, name))
            .ok_or_else(|| (format!("no state `{name}`"), hint::proposal(name, &self.states)))
    }

    fn states(&self, machine: &str) -> Result<States<'_>, Unknown> {
        let found = self.machines.iter().position(|known| known.name == machine);
        let states = found.map(|index| States {
            slot: self.machine(index),
            entered: self.entered(index),
            names: &self.machines[index].states,
        });
        states.ok_or_else(|| {
            let known: Vec<&str> = self.machines.iter().map(|known| known.name.as_str()).collect();
            (format!("no machine `{machine}`"), hint::proposal(machine, &known))
        })
    }

    fn named(&self, variable: &str, value: &str) -> Result<f64, Unknown> {
        let unknown = |known: &[&str]| {
            (format!("`{variable}` is never `{value}`"), hint::proposal(value, known))
        };
        if let Some(machine) = self.machines.iter().find(|known| known.name == variable) {
            let known: Vec<&str> = machine.states.iter().map(String::as_str).collect();
            let place = known.iter().position(|known| *known == value);
            return place.map(|place| place as f64).ok_or_else(|| unknown(&known));
        }
        let Ok((message, signal)) = self.layout.resolve_among(variable, Some(Sender::Host)) else {
            let help = "machines have names of their states, and signals that are heard where the DBC names values";
            return Err((format!("values of `{variable}` have no names"), help.to_owned()));
        };
        let signal = &self.layout.messages()[message].signals[signal];
        let known: Vec<(&str, f64)> = signal.names().collect();
        let found = known.iter().find(|(name, _)| *name == value);
        let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
        found.map(|(_, number)| *number).ok_or_else(|| unknown(&names))
    }
}

/// Scope with parameters and tables only, for the start of a state.
pub(super) struct ParametersOnly<'a>(pub(super) &'a Variables);

impl Scope for ParametersOnly<'_> {
    fn variable(&self, name: &str) -> Result<Meaning, Unknown> {
        let found = self.0.parameters.iter().position(|known| known == name);
        found
            .map(|index| Meaning::Slot(self.0.parameter(index)))
            .or_else(|| find(&self.0.arrays.parameters, name))
            .or_else(|| self.0.tables.get(name).cloned().map(Meaning::Table))
            .ok_or_else(|| {
                let help = hint::proposal(name, &self.0.parameters);
                (format!("`{name}` is not a parameter, and a start is made of those alone"), help)
            })
    }

    fn states(&self, machine: &str) -> Result<States<'_>, Unknown> {
        self.variable(machine).and_then(|_| Scope::states(self.0, machine))
    }

    fn named(&self, variable: &str, value: &str) -> Result<f64, Unknown> {
        self.variable(variable).and_then(|_| self.0.named(variable, value))
    }
}

/// Names known to some expressions only: the index of an array, and the part of an answer.
#[derive(Clone, Copy)]
pub(super) struct Local<'a> {
    pub(super) scope: &'a dyn Scope,
    pub(super) index: Option<u32>,
    pub(super) has_parts: bool,
}

impl Scope for Local<'_> {
    fn variable(&self, name: &str) -> Result<Meaning, Unknown> {
        if let (Some(index), INDEX) = (self.index, name) {
            return Ok(Meaning::Number(f64::from(index)));
        }
        match self.scope.variable(name) {
            // A variable of the file takes precedence.
            Err(_) if self.has_parts && name == PART_NAME => Ok(Meaning::Slot(PART)),
            found => found,
        }
    }

    fn last(&self, name: &str) -> Result<Meaning, Unknown> {
        self.scope.last(name)
    }

    fn states(&self, machine: &str) -> Result<States<'_>, Unknown> {
        self.scope.states(machine)
    }

    fn named(&self, variable: &str, value: &str) -> Result<f64, Unknown> {
        self.scope.named(variable, value)
    }
}
