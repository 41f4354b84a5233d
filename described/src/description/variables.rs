//! The variables of a device, each in a slot: time, parameters, states, states one step before, and the
//! signals of the messages that it hears.

use crate::expression::Scope;
use crate::hint;
use crate::layout::{Layout, Sender, SignalName};

/// The slot of the time since power-on, in seconds.
pub(crate) const TIME: usize = 0;

/// Which name is in which slot.
#[derive(Debug, Clone)]
pub(crate) struct Variables {
    parameters: Vec<String>,
    states: Vec<String>,
    layout: Layout,
    /// The first slot of each message that is heard.
    heard: Vec<Option<usize>>,
    count: usize,
}

impl Variables {
    pub(super) fn new(parameters: Vec<String>, states: Vec<String>, layout: Layout) -> Self {
        let mut count = 1 + parameters.len() + 2 * states.len();
        let mut slots = |message: &crate::layout::Message| {
            let first = count;
            count += message.signals.len();
            first
        };
        let heard = layout.messages().iter();
        let heard = heard.map(|message| (message.sender == Sender::Host).then(|| slots(message)));
        let heard = heard.collect();
        Self { parameters, states, layout, heard, count }
    }

    /// The names of the states.
    pub(crate) fn states(&self) -> impl Iterator<Item = &str> {
        self.states.iter().map(String::as_str)
    }

    /// How many slots there are.
    pub(crate) const fn count(&self) -> usize {
        self.count
    }

    pub(crate) const fn parameter(&self, index: usize) -> usize {
        1 + index
    }

    pub(crate) const fn state(&self, index: usize) -> usize {
        1 + self.parameters.len() + index
    }

    /// The state as it was at the end of the step before.
    pub(crate) const fn last_state(&self, index: usize) -> usize {
        self.state(index) + self.states.len()
    }

    /// The slot of a signal that is heard.
    pub(crate) fn signal(&self, message: usize, signal: usize) -> Option<usize> {
        self.heard.get(message).copied().flatten().map(|first| first + signal)
    }

    /// The slot of a parameter or a state.
    pub(crate) fn inner(&self, name: &str) -> Option<usize> {
        let place = |names: &[String]| names.iter().position(|known| known == name);
        place(&self.parameters)
            .map(|index| self.parameter(index))
            .or_else(|| place(&self.states).map(|index| self.state(index)))
    }

    /// Which state's slot it is.
    pub(super) fn state_in(&self, slot: usize) -> Option<usize> {
        slot.checked_sub(self.state(0)).filter(|index| *index < self.states.len())
    }

    /// Whether the slot has a state as it was one step before.
    pub(super) fn is_last(&self, slot: usize) -> bool {
        (self.last_state(0)..self.last_state(self.states.len())).contains(&slot)
    }

    fn unknown(&self, name: &str) -> (String, String) {
        if self.layout.resolve_among(name, Some(Sender::Device)).is_ok() {
            let help = "write the states and parameters that it shows".to_owned();
            return (format!("`{name}` is sent, not heard"), help);
        }
        let inner = self.parameters.iter().chain(&self.states).cloned();
        let messages = self.layout.messages().iter().filter(|m| m.sender == Sender::Host);
        let signals = messages.flat_map(|message| {
            message.signals.iter().map(|signal| match name.contains('.') {
                true => format!("{}.{}", message.name, signal.name),
                false => signal.name.clone(),
            })
        });
        let known: Vec<String> = inner.chain(signals).collect();
        (format!("no variable `{name}`"), hint::proposal(name, &known))
    }
}

impl Scope for Variables {
    fn variable(&self, name: &str) -> Result<usize, (String, String)> {
        if name == "t" {
            return Ok(TIME);
        }
        if let Some(slot) = self.inner(name) {
            return Ok(slot);
        }
        match self.layout.resolve_among(name, Some(Sender::Host)) {
            Ok((message, signal)) => self.signal(message, signal).ok_or_else(|| self.unknown(name)),
            Err(SignalName::Unknown { .. }) => Err(self.unknown(name)),
            Err(error) => Err((error.to_string(), error.advice().to_owned())),
        }
    }

    fn last(&self, name: &str) -> Result<usize, (String, String)> {
        let found = self.states.iter().position(|known| known == name);
        found
            .map(|index| self.last_state(index))
            .ok_or_else(|| (format!("no state `{name}`"), hint::proposal(name, &self.states)))
    }
}

/// Parameters alone: what the start of a state may be made of.
pub(super) struct ParametersOnly<'a>(pub(super) &'a Variables);

impl Scope for ParametersOnly<'_> {
    fn variable(&self, name: &str) -> Result<usize, (String, String)> {
        let found = self.0.parameters.iter().position(|known| known == name);
        found.map(|index| self.0.parameter(index)).ok_or_else(|| {
            let help = hint::proposal(name, &self.0.parameters);
            (format!("`{name}` is not a parameter, and a start is made of those alone"), help)
        })
    }

    fn last(&self, name: &str) -> Result<usize, (String, String)> {
        self.variable(name)
    }
}
