//! Formulas of a plan: the signals that they may name are those that the nodes of its rig send.

use super::quantity::OfMessage;
use super::speakers::{DEVICE, MessagePlace, Speaker, resolve, signal};
use std::collections::BTreeMap;
use temporal::{Formula, Mistake, NotFound, Signal, Signals};

/// Reads a formula over the signals of `speakers`: `manager.ContactorCommand`, `manager.Status.ContactorCommand`, and
/// `ContactorCommand` where one node alone sends a signal of that name.
///
/// # Errors
///
/// The first mistake, with its place in the text.
pub fn formula(text: &str, speakers: &[Speaker]) -> Result<Formula, Mistake> {
    Formula::parse(text, &Sent(speakers))
}

/// The signals of `speakers`, in the order of the numbers that a [`formula`] has for them.
pub fn signals(speakers: &[Speaker]) -> impl Iterator<Item = MessagePlace> {
    speakers.iter().enumerate().flat_map(|(speaker, one)| {
        one.layout.messages().iter().enumerate().flat_map(move |(message, of)| {
            let signals = 0..of.signals.len();
            signals.map(move |signal| MessagePlace { speaker, message, signal: Some(signal) })
        })
    })
}

struct Sent<'a>(&'a [Speaker]);

impl Sent<'_> {
    fn at(&self, place: MessagePlace) -> Option<Signal> {
        let found = signal(self.0, place)?;
        let names = found.names().map(|(name, value)| (name.to_owned(), value));
        let index = signals(self.0).position(|known| known == place)?;
        Some(Signal { index, unit: found.unit.clone(), names: names.collect() })
    }

    /// Every signal that is sent, by its node and name.
    fn names(&self) -> Vec<String> {
        let of = |speaker: &Speaker| {
            let node = speaker.node.clone();
            let signals = speaker.messages().flat_map(|message| message.signals.clone());
            signals
                .map(move |signal| match node.as_str() {
                    DEVICE => signal.name,
                    node => format!("{node}.{}", signal.name),
                })
                .collect::<Vec<_>>()
        };
        let mut names: Vec<String> = self.0.iter().flat_map(of).collect();
        names.sort();
        names.dedup();
        names
    }
}

impl Signals for Sent<'_> {
    fn find(&self, name: &str) -> Result<Signal, NotFound> {
        let nodes = |node: &str| self.0.iter().any(|speaker| speaker.node == node);
        let found = match name.split_once('.') {
            Some((node, name)) if nodes(node) => resolve(self.0, OfMessage::Signal { node, name }),
            _ => {
                let mut owners: Vec<&str> = self.0.iter().map(|one| one.node.as_str()).collect();
                owners.dedup();
                let of = |node| {
                    resolve(self.0, OfMessage::Signal { node, name }).ok().map(|at| (node, at))
                };
                let found: Vec<(&str, MessagePlace)> = owners.into_iter().filter_map(of).collect();
                match found.as_slice() {
                    [(_, only)] => Ok(*only),
                    [] => return Err(NotFound::unknown(name, &self.names())),
                    several => {
                        let full = several.iter().map(|(node, _)| format!("{node}.{name}"));
                        return Err(NotFound::ambiguous(name, &full.collect::<Vec<_>>()));
                    }
                }
            }
        };
        match found {
            Ok(place) => self.at(place).ok_or_else(|| NotFound::unknown(name, &self.names())),
            Err((message, _)) => {
                let help = NotFound::unknown(name, &self.names()).help;
                Err(NotFound { message, help })
            }
        }
    }
}

/// Which signals of which messages some formulas read.
#[derive(Debug, Clone, Default)]
pub struct Reads {
    /// Of each message, by its speaker and place: which of its signals, and the number that formulas have for it.
    messages: BTreeMap<(usize, usize), Vec<(usize, usize)>>,
    values: Vec<(usize, f64)>,
}

impl Reads {
    /// What `formulas` read of what `speakers` send.
    pub fn of<'a>(formulas: impl IntoIterator<Item = &'a Formula>, speakers: &[Speaker]) -> Self {
        let places: Vec<MessagePlace> = signals(speakers).collect();
        let mut messages: BTreeMap<_, Vec<_>> = BTreeMap::new();
        for used in formulas.into_iter().flat_map(Formula::signals) {
            let place = places.get(used.index);
            let Some((place, signal)) = place.and_then(|one| Some((one, one.signal?))) else {
                continue;
            };
            let read = messages.entry((place.speaker, place.message)).or_default();
            if !read.contains(&(signal, used.index)) {
                read.push((signal, used.index));
            }
        }
        Self { messages, values: Vec::new() }
    }

    /// What a message brings, by the numbers of formulas; none where no formula reads it. `values` are those of its signals,
    /// as far as it carries them.
    pub fn take(&mut self, of: (usize, usize), values: &[Option<f64>]) -> Option<&[(usize, f64)]> {
        let read = self.messages.get(&of)?;
        self.values.clear();
        self.values.extend(read.iter().filter_map(|(signal, number)| {
            let value = values.get(*signal).copied().flatten()?;
            Some((*number, value))
        }));
        Some(&self.values)
    }
}
