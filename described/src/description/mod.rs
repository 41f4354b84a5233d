//! What a description says of a device.

mod messages;
mod parameters;
mod read;
mod sending;
mod source;
mod states;
mod variables;

#[cfg(test)]
pub(crate) mod tests;

pub(crate) use messages::{Heard, Sent};
pub(crate) use source::{SignalSource, Source};
pub(crate) use states::{Law, State};
pub(crate) use variables::{TIME, Variables};

use crate::error::{DescriptionError, Mistake};
use crate::expression::{Expression, Scope};
use crate::file::{File, Formula, MessageRules};
use crate::files::{Files, Texts};
use crate::layout::Layout;
use crate::place::Place;
use parameters::Parameter;
use std::collections::BTreeMap;
use wire::time::Span;

/// The step of the integration where the file says none.
const STEP_S: f64 = 0.01;

/// Steps shorter than this are not worth their time. Assumption: no line here resolves less.
const STEP_S_MIN: f64 = 10e-6;

/// A device as its user describes it, checked.
#[derive(Debug, Clone)]
pub struct Description {
    /// Its name, which its random numbers belong to.
    pub name: String,
    /// What it is, in a line.
    pub title: String,
    /// Where its numbers come from.
    pub source: String,
    layout: Layout,
    parameters: Vec<Parameter>,
    /// Of parameters and states.
    notes: BTreeMap<String, Note>,
    pub(crate) model: Model,
}

/// What a file says of a parameter or a state beside its numbers.
#[derive(Debug, Clone)]
struct Note {
    unit: String,
    doc: String,
}

/// What a device computes.
#[derive(Debug, Clone)]
pub(crate) struct Model {
    pub(crate) step: Span,
    pub(crate) variables: Variables,
    pub(crate) states: Vec<State>,
    /// The states with a value, each behind those that it needs.
    pub(crate) order: Vec<usize>,
    pub(crate) sent: Vec<Sent>,
    pub(crate) heard: Vec<Heard>,
}

impl Description {
    /// Reads a description without identified models. `file` is its name in messages; `read` hands over the files
    /// that it names (a DBC, CSV) by the name in the description, or says why it cannot.
    ///
    /// # Errors
    /// As [`Description::parse_with`].
    pub fn parse(
        file: &str,
        text: &str,
        read: &mut dyn FnMut(&str) -> Result<String, String>,
    ) -> Result<Self, DescriptionError> {
        Self::parse_with(file, text, &mut Texts(read))
    }

    /// Reads a description. `file` is its name in messages.
    ///
    /// # Errors
    /// With the place of the first mistake, in the description or in a file that it names.
    pub fn parse_with(
        file: &str,
        text: &str,
        files: &mut dyn Files,
    ) -> Result<Self, DescriptionError> {
        let (said, tables) = read::split(file, text)?;
        let layout = read::layout(file, text, &said, tables.as_deref(), files)?;
        Self::build(said, layout, tables.is_some(), files)
            .map_err(|mistake| mistake.located(file, text))
    }

    fn build(
        said: File<BTreeMap<String, MessageRules>>,
        layout: Layout,
        listed: bool,
        files: &mut dyn Files,
    ) -> Result<Self, Mistake> {
        let step = said.step_s.unwrap_or(STEP_S);
        let step = messages::seconds(step, STEP_S_MIN, &Place::file().key("step_s"))?;
        let layout = messages::ruled(layout, &said.message, listed)?;
        let parameters = parameters::parameters(&said.parameter, &said.state)?;
        let of_parameters =
            said.parameter.iter().map(|(name, table)| (name, &table.unit, &table.doc));
        let of_states = said.state.iter().map(|(name, table)| (name, &table.unit, &table.doc));
        let notes = of_parameters
            .chain(of_states)
            .map(|(name, unit, doc)| (name.clone(), Note { unit: unit.clone(), doc: doc.clone() }));
        let notes = notes.collect();
        let names = parameters.iter().map(|known| known.name.clone()).collect();
        let states = said.state.keys().cloned().collect();
        let variables = Variables::new(names, states, layout.clone());
        let (states, order) = states::states(&said.state, &variables)?;
        let (sent, heard) =
            messages::messages(&said.message, &said.signal, &layout, &variables, listed, files)?;
        let model = Model { step, variables, states, order, sent, heard };
        let (name, title, source) = (said.name, said.title, said.source);
        Ok(Self { name, title, source, layout, parameters, notes, model })
    }

    /// The same by another name, and so with other random numbers: of several devices of one description each has its own.
    #[must_use]
    pub fn named(&self, name: &str) -> Self {
        Self { name: name.to_owned(), ..self.clone() }
    }

    /// Its messages and their signals.
    pub const fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Its parameters: name, value and unit, by name.
    pub fn parameters(&self) -> impl Iterator<Item = (&str, f64, &str)> {
        self.parameters.iter().map(|known| (known.name.as_str(), known.value, known.unit.as_str()))
    }

    /// The unit of a parameter, a state or a signal, as its file writes it.
    pub fn unit(&self, name: &str) -> Option<&str> {
        let signal = |(message, signal): (usize, usize)| {
            self.layout.messages()[message].signals[signal].unit.as_str()
        };
        self.notes
            .get(name)
            .map(|note| note.unit.as_str())
            .or_else(|| self.layout.signal(name).map(signal))
    }

    /// What the file says of a parameter, a state or a signal.
    pub fn doc(&self, name: &str) -> Option<&str> {
        let signal = |(message, signal): (usize, usize)| {
            self.layout.messages()[message].signals[signal].doc.as_str()
        };
        self.notes
            .get(name)
            .map(|note| note.doc.as_str())
            .or_else(|| self.layout.signal(name).map(signal))
    }

    /// Gives a parameter another value from the start, which states begin with too. [`Device::set_parameter`]
    /// changes it on the way.
    ///
    /// # Errors
    /// As [`Description::check_parameter`], and nothing is changed.
    ///
    /// [`Device::set_parameter`]: crate::Device::set_parameter
    pub fn set_parameter(&mut self, name: &str, value: f64) -> Result<(), String> {
        self.check_parameter(name, value)?;
        if let Some(known) = self.parameters.iter_mut().find(|known| known.name == name) {
            known.value = value;
        }
        Ok(())
    }

    /// Its states, by name.
    pub fn states(&self) -> impl Iterator<Item = &str> {
        self.model.variables.states()
    }

    /// Whether the parameter exists and may have this value.
    ///
    /// # Errors
    /// With a message for people: the nearest name, or the range.
    pub fn check_parameter(&self, name: &str, value: f64) -> Result<(), String> {
        parameters::check(&self.parameters, name, value)
    }
}

/// The expression of a number or a text, whose mistakes are shown where they are.
fn formula(formula: &Formula, scope: &dyn Scope, place: &Place) -> Result<Expression, Mistake> {
    match formula {
        Formula::Number(number) => Ok(Expression::constant(*number)),
        Formula::Expression(text) => Expression::parse(text, scope).map_err(|error| {
            let mistake = Mistake::new(place.within(error.at), error.message);
            Mistake { help: error.help, ..mistake }
        }),
    }
}
