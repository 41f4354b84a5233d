//! Finds messages and signals by their names. Files have thousands of both, and every line of a plan names one.

use super::message::Message;
use std::collections::BTreeMap;

/// The index of a signal's message, and the position of the signal in it.
pub(super) type Place = (usize, usize);

/// Places of messages and signals.
#[derive(Debug, Clone, Default)]
pub(super) struct Names {
    /// In the order of the file.
    messages: BTreeMap<Box<str>, Vec<usize>>,
    /// In the order of the file.
    signals: BTreeMap<Box<str>, Vec<Place>>,
}

impl Names {
    pub(super) fn of(messages: &[Message]) -> Self {
        let mut names = Self::default();
        for (index, message) in messages.iter().enumerate() {
            names.messages.entry(message.name.as_str().into()).or_default().push(index);
            for (position, signal) in message.signals.iter().enumerate() {
                let places = names.signals.entry(signal.name.as_str().into()).or_default();
                places.push((index, position));
            }
        }
        names
    }

    /// The first message of this name.
    pub(super) fn message(&self, name: &str) -> Option<usize> {
        self.messages.get(name)?.first().copied()
    }

    /// All signals called `Temperature` or, with a message, `Status.Temperature`. `messages` are those of [`Names::of`].
    pub(super) fn signals(&self, name: &str, messages: &[Message]) -> Vec<Place> {
        if !name.contains('.') {
            return self.signals.get(name).cloned().unwrap_or_default();
        }
        let parts = name.match_indices('.').map(|(dot, _)| (&name[..dot], &name[dot + 1..]));
        let places = parts.flat_map(|(message, signal)| {
            let of_name = self.messages.get(message).into_iter().flatten();
            of_name.flat_map(move |index| {
                let signals = messages[*index].signals.iter().enumerate();
                let called = signals.filter(move |(_, known)| known.name == signal);
                called.map(|(position, _)| (*index, position))
            })
        });
        places.collect()
    }
}
