//! Meaning of names in the expressions of a file.

use super::arrays::{Family, INDEX};
use super::formula::formula;
use super::source::{Source, source};
use super::variables::{PART, TIME, Variables};
use crate::error::Mistake;
use crate::expression::{Array, Expression, Meaning, Scope, States, Unknown};
use crate::file::{Formula, SourceTable};
use crate::files::Files;
use crate::hint;
use crate::layout::{Sender, SignalName};
use crate::place::Place;

/// The name of the current part of an answer, from 1.
const PART_NAME: &str = "part";

/// The arrays by name.
#[derive(Debug, Clone, Default)]
pub(super) struct Arrays {
    parameters: Vec<(String, Array)>,
    states: Vec<(String, Array)>,
    /// States at the end of the previous step.
    last: Vec<(String, Array)>,
}

impl Arrays {
    /// Arrays of parameters with their first slot; arrays of states with their first slots now and one step before.
    pub(super) fn new(parameters: (&[Family], usize), states: (&[Family], usize, usize)) -> Self {
        let arrays = |families: &[Family], slot: usize| {
            let array = |family: &Family| {
                let slot = u32::try_from(slot + family.begin).unwrap_or(u32::MAX);
                let (count, first) = (family.count, family.first);
                (family.name.clone(), Array { slot, count, first })
            };
            families.iter().map(array).collect()
        };
        Self {
            parameters: arrays(parameters.0, parameters.1),
            states: arrays(states.0, states.1),
            last: arrays(states.0, states.2),
        }
    }

    pub(super) fn of_states(&self) -> impl Iterator<Item = String> {
        self.states.iter().map(|(name, _)| name.clone())
    }

    pub(super) fn names(&self) -> impl Iterator<Item = String> {
        self.parameters.iter().chain(&self.states).map(|(name, _)| name.clone())
    }
}

fn find(arrays: &[(String, Array)], name: &str) -> Option<Meaning> {
    let found = arrays.iter().find(|(known, _)| known == name);
    found.map(|(_, array)| Meaning::Array(*array))
}

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

    fn time(&self) -> usize {
        TIME
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

    fn last(&self, name: &str) -> Result<Meaning, Unknown> {
        self.variable(name)
    }

    fn states(&self, machine: &str) -> Result<States<'_>, Unknown> {
        self.variable(machine).and_then(|_| Scope::states(self.0, machine))
    }

    fn named(&self, variable: &str, value: &str) -> Result<f64, Unknown> {
        self.variable(variable).and_then(|_| self.0.named(variable, value))
    }

    fn time(&self) -> usize {
        TIME
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

    fn time(&self) -> usize {
        self.scope.time()
    }
}

/// Reads the parts of a file that are not messages: their expressions see all variables.
pub(crate) struct Scopes<'a> {
    pub(super) variables: &'a Variables,
    pub(super) files: &'a mut dyn Files,
}

impl Scopes<'_> {
    const fn local(&self) -> Local<'_> {
        Local { scope: self.variables, index: None, has_parts: false }
    }

    /// The slot of a state or a parameter.
    pub(crate) fn variable(&self, name: &str) -> Option<usize> {
        self.variables.inner(name)
    }

    pub(crate) fn expression(&self, text: &Formula, at: &Place) -> Result<Expression, Mistake> {
        formula(text, &self.local(), at)
    }

    pub(crate) fn source(
        &mut self,
        table: &SourceTable,
        unit: &str,
        at: &Place,
    ) -> Result<Source, Mistake> {
        let scope = Local { scope: self.variables, index: None, has_parts: false };
        source(table, unit, &scope, at, self.files).map(|found| found.source)
    }
}
