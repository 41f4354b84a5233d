//! The content of a description.

mod answers;
mod arrays;
mod canopen;
mod fmu;
mod formula;
mod machines;
mod messages;
mod parameters;
mod parts;
mod read;
mod scope;
mod sending;
mod source;
mod states;
mod tables;
mod uds;
mod variables;

#[cfg(test)]
pub(crate) mod tests;

pub(crate) use self::canopen::{Canopen, Object};
pub(crate) use answers::{Answer, TIMES_MAX, WhileAnswering};
pub(crate) use fmu::Physics;
pub(crate) use machines::{Machine, Setting};
pub(crate) use messages::{Heard, Sent};
pub(crate) use source::{SignalSource, Source};
pub(crate) use states::{Law, State};
pub(crate) use variables::{PART, Variables};

use crate::error::{FileError, Mistake, Read};
use crate::expression::Batch;
use crate::file::{File, MachineTable, ParameterTable, StateTable};
use crate::files::{Files, Texts};
use crate::isotp::IsoTp;
use crate::layout::Layout;
use crate::place::Place;
use crate::uds::Diagnosis;
use arrays::{Entry, Family};
use parameters::Parameter;
use std::collections::BTreeMap;
use variables::Named;
use wire::time::Span;

const STEP_S: f64 = 0.01;

/// Minimum step. Assumption: no line here resolves less.
const STEP_S_MIN: f64 = 10e-6;

/// A device as described by its user, checked.
#[derive(Debug, Clone)]
pub struct Description {
    /// Name, the key of its random numbers.
    pub name: String,
    /// One-line description.
    pub title: String,
    /// The source of its numbers.
    pub source: String,
    layout: Layout,
    parameters: Vec<Parameter>,
    notes: BTreeMap<String, Note>,
    pub(crate) model: Model,
}

/// Documentation and unit of a parameter or a state.
#[derive(Debug, Clone)]
struct Note {
    unit: String,
    doc: String,
}

#[derive(Debug, Clone)]
pub(crate) struct Model {
    pub(crate) step: Span,
    pub(crate) variables: Variables,
    pub(crate) states: Vec<State>,
    /// The states with a value, each after those that it depends on.
    pub(crate) order: Vec<usize>,
    pub(crate) machines: Vec<Machine>,
    pub(crate) sent: Vec<Sent>,
    /// The sent signals that are expressions.
    pub(crate) expressions: Batch,
    pub(crate) heard: Vec<Heard>,
    pub(crate) uds: Option<Box<Diagnosis>>,
    pub(crate) canopen: Option<Canopen>,
    /// A functional mock-up unit.
    pub(crate) physics: Option<Box<Physics>>,
}

impl Description {
    /// Reads a description without identified models. `file` is its name in error messages; `read` returns the files
    /// that it names (a DBC, CSV) by the name in the description, or the reason why it cannot.
    ///
    /// # Errors
    /// As [`Description::parse_with`].
    pub fn parse(
        file: &str,
        text: &str,
        read: &mut dyn FnMut(&str) -> Result<String, String>,
    ) -> Result<Self, FileError> {
        Self::parse_with(file, text, &mut Texts(read))
    }

    /// Reads a description. `file` is its name in error messages.
    ///
    /// # Errors
    /// With the place of the first mistake, in the description or in a file that it names.
    pub fn parse_with(file: &str, text: &str, files: &mut dyn Files) -> Result<Self, FileError> {
        let said = read::said(file, text)?;
        let layout = read::layout(file, text, &said, files)?;
        Self::build(said, layout, files).map_err(|mistake| mistake.located(file, text))
    }

    fn build(mut said: File, layout: Layout, files: &mut dyn Files) -> Read<Self> {
        let (rules, listed) = (said.message.rules(), said.message.tables().is_some());
        let step_s = said.step_s.unwrap_or(STEP_S);
        let step = parts::seconds(step_s, STEP_S_MIN, &Place::file().key("step_s"))?;
        let dictionary = layout.dictionary().cloned();
        let held = dictionary.iter().map(|dictionary| crate::canopen::held(&mut said, dictionary));
        let held = held.collect::<Result<Vec<_>, _>>()?.concat();
        let loaded = fmu::load(&mut said, files)?;
        let layout = messages::ruled(layout, &rules, listed)?;
        let of_uds = Place::file().key("uds").key("isotp");
        let isotp = said.uds.as_ref().map(|uds| IsoTp::at(&uds.isotp, &of_uds)).transpose()?;
        let layout = match &isotp {
            Some(isotp) => layout
                .with_isotp(isotp)
                .map_err(|(key, text)| Mistake::new(of_uds.key(key), text))?,
            None => layout,
        };
        let (of_parameters, parameter_arrays) = arrays::entries(&said.parameter, "parameter")?;
        let (of_states, state_arrays) = arrays::entries(&said.state, "state")?;
        let machine_tables = machines::in_order(&said.machine);
        let others = said.table.keys().map(|name| ("table", name.as_str()));
        let others = others.chain(machine_tables.iter().map(|(name, _)| ("machine", *name)));
        parameters::names(&of_parameters, &of_states, &others.clone().collect::<Vec<_>>())?;
        distinct(&of_parameters, &of_states, [&parameter_arrays, &state_arrays], others)?;
        arrays::index_is_free(&said.parameter, &said.state, &said.signal)?;
        let named = Named {
            machines: machines::names(&machine_tables)?,
            tables: tables::tables(&said.table, files)?,
            parameter_arrays,
            state_arrays,
        };
        let parameters = parameters::parameters(&of_parameters, &named.parameter_arrays)?;
        let notes = notes(&of_parameters, &of_states, &machine_tables);
        let names = parameters.iter().map(|known| known.name.clone()).collect();
        let state_names = of_states.iter().map(|entry| entry.name.clone()).collect();
        let variables = Variables::new(names, state_names, named, layout.clone());
        let mut set = machines::set(&machine_tables, &variables)?;
        let fmu = said.fmu.as_ref().zip(loaded);
        let physics = fmu.map(|(table, loaded)| {
            fmu::units(table, &*loaded.unit, &layout, &said.signal, files)?;
            fmu::physics(table, loaded, &variables, &set, step_s)
        });
        let physics = physics.transpose()?.map(Box::new);
        set.extend(said.fmu.iter().flat_map(|fmu| fmu.outputs.keys()).map(String::as_str));
        set.extend(held.iter().map(String::as_str));
        let (states, order) = states::states(&of_states, &set, &variables)?;
        let machines = machines::machines(&machine_tables, &states, &variables)?;
        let (mut sent, heard) =
            messages::messages(&rules, &said.signal, &layout, &variables, listed, files)?;
        let expressions = messages::expressions(&mut sent);
        let uds = said.uds.as_ref().zip(isotp);
        let uds = uds.map(|(uds, isotp)| uds::diagnosis(uds, isotp, &variables, &parameters));
        let uds = uds.transpose()?.map(Box::new);
        let canopen =
            dictionary.map(|dictionary| canopen::canopen(&said, &dictionary, &variables, files));
        let canopen = canopen.transpose()?;
        let model = Model {
            step,
            variables,
            states,
            order,
            machines,
            sent,
            expressions,
            heard,
            uds,
            canopen,
            physics,
        };
        let (name, title, source) = (said.name, said.title, said.source);
        Ok(Self { name, title, source, layout, parameters, notes, model })
    }

    /// The description under another name, and so with other random numbers: each of several devices of one
    /// description needs its own.
    #[must_use]
    pub fn named(&self, name: &str) -> Self {
        Self { name: name.to_owned(), ..self.clone() }
    }

    /// The messages and their signals.
    pub const fn layout(&self) -> &Layout {
        &self.layout
    }

    /// The ISO-TP channel of its diagnostics, if it has any.
    pub fn isotp(&self) -> Option<&IsoTp> {
        self.model.uds.as_ref().map(|uds| &uds.isotp)
    }

    /// The parameters: name, value and unit, ordered by name.
    pub fn parameters(&self) -> impl Iterator<Item = (&str, f64, &str)> {
        self.parameters.iter().map(|known| (known.name.as_str(), known.value, known.unit.as_str()))
    }

    /// The least and the greatest value that a parameter takes, in its unit; infinite where there is no limit.
    pub fn range(&self, parameter: &str) -> Option<(f64, f64)> {
        let known = self.parameters.iter().find(|known| known.name == parameter)?;
        Some((known.minimum, known.maximum))
    }

    /// Whether the signals of a received message return to their initial values when it no longer comes.
    pub fn times_out(&self, message: usize) -> bool {
        let mut heard = self.model.heard.iter();
        heard.any(|heard| heard.message == message && heard.timeout.is_some())
    }

    /// The unit of a parameter, a state or a signal, as written in the file.
    pub fn unit(&self, name: &str) -> Option<&str> {
        self.about(name).map(|(unit, _)| unit)
    }

    /// The documentation of a parameter, a state or a signal.
    pub fn doc(&self, name: &str) -> Option<&str> {
        self.about(name).map(|(_, doc)| doc)
    }

    /// The unit and the documentation.
    fn about(&self, name: &str) -> Option<(&str, &str)> {
        if let Some(note) = self.notes.get(name) {
            return Some((&note.unit, &note.doc));
        }
        let (message, signal) = self.layout.signal(name)?;
        let signal = &self.layout.messages()[message].signals[signal];
        Some((&signal.unit, &signal.doc))
    }

    /// Sets the start value of a parameter, or of all elements of an array, which also affects states that start with
    /// it. [`Device::set_parameter`] changes it during a run.
    ///
    /// # Errors
    /// As [`Description::check_parameter`]; nothing is changed then.
    ///
    /// [`Device::set_parameter`]: crate::Device::set_parameter
    pub fn set_parameter(&mut self, name: &str, value: f64) -> Result<(), String> {
        self.check_parameter(name, value)?;
        for place in parameters::named(&self.parameters, name) {
            self.parameters[place].value = value;
        }
        Ok(())
    }

    /// The indices of the parameters with this name: one, or all of an array.
    pub(crate) fn parameters_named(&self, name: &str) -> Vec<usize> {
        parameters::named(&self.parameters, name)
    }

    /// The names of its states and machines.
    pub fn states(&self) -> impl Iterator<Item = &str> {
        self.model.variables.states()
    }

    /// Checks that the parameter exists and may have this value.
    ///
    /// # Errors
    /// With a readable message: the nearest name, or the range.
    pub fn check_parameter(&self, name: &str, value: f64) -> Result<(), String> {
        parameters::check(&self.parameters, name, value)
    }
}

/// The notes of parameters, states and machines.
fn notes(
    parameters: &[Entry<'_, ParameterTable>],
    states: &[Entry<'_, StateTable>],
    machines: &[(&str, &MachineTable)],
) -> BTreeMap<String, Note> {
    let note = |unit: &str, doc: &str| Note { unit: unit.to_owned(), doc: doc.to_owned() };
    let parameters =
        parameters.iter().map(|one| (one.name.clone(), note(&one.table.unit, &one.table.doc)));
    let states = states.iter().map(|one| (one.name.clone(), note(&one.table.unit, &one.table.doc)));
    let machines = machines.iter().map(|(name, table)| ((*name).to_owned(), note("", &table.doc)));
    parameters.chain(states).chain(machines).collect()
}

/// Checks that the names of variables, arrays, tables and machines are unique.
fn distinct<'a>(
    parameters: &'a [Entry<'_, ParameterTable>],
    states: &'a [Entry<'_, StateTable>],
    arrays: [&'a [Family]; 2],
    others: impl Iterator<Item = (&'static str, &'a str)>,
) -> Read {
    let of_parameters = parameters.iter().map(|one| ("parameter", one.key, one.name.as_str()));
    let of_states = states.iter().map(|one| ("state", one.key, one.name.as_str()));
    let [of_arrays, of_others] = arrays;
    let keys = of_arrays.iter().map(|family| ("parameter", parameters[family.begin].key, family));
    let others_keys = of_others.iter().map(|family| ("state", states[family.begin].key, family));
    let families = keys.chain(others_keys);
    let families = families.map(|(section, key, family)| (section, key, family.name.as_str()));
    let others = others.map(|(section, name)| (section, name, name));
    arrays::distinct(of_parameters.chain(of_states).chain(families).chain(others))
}
