//! Formulas of a plan, over the signals that the nodes of its rig send.

use super::speakers::{DEVICE, MessagePlace, OfMessage, Speaker, resolve, signal, which};
use described::hint::proposal;
use described::{Decoded, Verdict};
use std::collections::BTreeMap;
use temporal::{Formula, Mistake, NotFound, Protecting, Signal, Signals};
use wire::time::{Span, Timestamp};

/// Parses a formula over the signals of `speakers`: `manager.ContactorCommand`, `manager.Status.ContactorCommand`, or
/// `ContactorCommand` if only one node sends a signal with that name.
///
/// # Errors
/// The first mistake, with its position in the text.
pub fn formula(text: &str, speakers: &[Speaker]) -> Result<Formula, Mistake> {
    Formula::parse(text, &Sent(speakers))
}

/// A value that a formula reads from a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// The value of a signal.
    Signal(MessagePlace),
    /// Whether the signal, a counter or a checksum, is correct: 1 or 0.
    Protecting(MessagePlace, Protecting),
    /// How many such messages there were.
    Count(MessagePlace),
}

impl Origin {
    /// The message, by speaker and index.
    const fn message(self) -> (usize, usize) {
        let (Self::Signal(place) | Self::Protecting(place, _) | Self::Count(place)) = self;
        (place.speaker, place.message)
    }

    fn value(self, decoded: &Decoded<'_>, count: u64) -> Option<f64> {
        match self {
            Self::Count(_) => Some(count as f64),
            Self::Signal(place) => decoded.values.get(place.signal?).copied().flatten(),
            Self::Protecting(_, how) => {
                let is_right = match (decoded.verdict?, how) {
                    (Verdict::WrongChecksum, Protecting::Fits) => false,
                    (_, Protecting::Fits)
                    | (Verdict::Ok | Verdict::LostToDamage(_), Protecting::Follows) => true,
                    // The counter of a damaged message carries no information.
                    (Verdict::WrongChecksum, Protecting::Follows) => return None,
                    (_, Protecting::Follows) => false,
                };
                Some(f64::from(u8::from(is_right)))
            }
        }
    }
}

/// All values that formulas may read from `speakers`, in the order of the numbers in a [`formula`].
pub fn origins(speakers: &[Speaker]) -> impl Iterator<Item = Origin> {
    speakers.iter().enumerate().flat_map(|(speaker, one)| {
        one.layout.messages().iter().enumerate().flat_map(move |(message, of)| {
            let at = move |signal| MessagePlace { speaker, message, signal: Some(signal) };
            let signals = (0..of.signals.len()).map(move |signal| Origin::Signal(at(signal)));
            let follows = of.counter_signal().map(|signal| (signal, Protecting::Follows));
            let fits = of.checksum_signal().map(|signal| (signal, Protecting::Fits));
            let protecting = follows.into_iter().chain(fits);
            let protecting =
                protecting.map(move |(signal, how)| Origin::Protecting(at(signal), how));
            let whole = MessagePlace { speaker, message, signal: None };
            signals.chain(protecting).chain([Origin::Count(whole)])
        })
    })
}

/// The speaker of each number in a [`formula`].
pub fn speakers_of(speakers: &[Speaker]) -> impl Iterator<Item = usize> {
    origins(speakers).map(|origin| origin.message().0)
}

struct Sent<'a>(&'a [Speaker]);

impl Sent<'_> {
    fn number(&self, origin: Origin) -> Option<usize> {
        origins(self.0).position(|known| known == origin)
    }

    fn unknown(&self, name: &str) -> NotFound {
        NotFound::unknown(name, &self.names())
    }

    /// The signal with this name.
    fn place(&self, name: &str) -> Result<MessagePlace, NotFound> {
        let nodes = |node: &str| self.0.iter().any(|speaker| speaker.node == node);
        if let Some((node, signal)) = name.split_once('.').filter(|(node, _)| nodes(node)) {
            let of = OfMessage::Signal { node, name: signal };
            return resolve(self.0, of).map_err(|(message, known)| {
                // As `names` has them.
                let wrong = if node == DEVICE { signal } else { name };
                let help = which(of, &known).or_else(|| self.unknown(wrong).help);
                NotFound { message, help }
            });
        }
        let mut owners: Vec<&str> = self.0.iter().map(|one| one.node.as_str()).collect();
        owners.dedup();
        let of = |node| resolve(self.0, OfMessage::Signal { node, name }).ok().map(|at| (node, at));
        let found: Vec<(&str, MessagePlace)> = owners.into_iter().filter_map(of).collect();
        match found.as_slice() {
            [(_, only)] => Ok(*only),
            [] => Err(self.unknown(name)),
            several => {
                let full = several.iter().map(|(node, _)| format!("{node}.{name}"));
                Err(NotFound::ambiguous(name, &full.collect::<Vec<_>>()))
            }
        }
    }

    /// Every signal that is sent, by node and name.
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
        let place = self.place(name)?;
        let found = signal(self.0, place).zip(self.number(Origin::Signal(place)));
        let (found, index) = found.ok_or_else(|| self.unknown(name))?;
        let names = found.names().map(|(name, value)| (name.to_owned(), value));
        Ok(Signal {
            index,
            unit: found.unit.clone(),
            names: names.collect(),
            range: Some((found.minimum, found.maximum)),
            step: found.resolution(),
        })
    }

    fn message(&self, name: &str) -> Result<Signal, NotFound> {
        let place = self.whole(name)?;
        let index = self.number(Origin::Count(place)).ok_or_else(|| self.unknown(name))?;
        Ok(Signal { index, ..Signal::default() })
    }

    fn protecting(&self, name: &str, how: Protecting) -> Result<Signal, NotFound> {
        let place = self.place(name)?;
        let number = self.number(Origin::Protecting(place, how));
        let index = number.ok_or_else(|| {
            let (what, key) = match how {
                Protecting::Follows => ("counter", "counter"),
                Protecting::Fits => ("checksum", "checksum"),
            };
            let help = format!(
                "declare it in the device file or at the line: `message.NAME = {{ {key} = {{ signal = ... }} }}`"
            );
            let message = format!("`{name}` is not declared as a {what}");
            NotFound { message, help: Some(help) }
        })?;
        Ok(Signal { index, ..Signal::default() })
    }
}

impl Sent<'_> {
    /// The message with this name.
    fn whole(&self, name: &str) -> Result<MessagePlace, NotFound> {
        let of = match name.split_once('.') {
            Some((node, name)) if self.0.iter().any(|one| one.node == node) => {
                OfMessage::Period { node, name }
            }
            _ => {
                let has = |one: &&Speaker| one.messages().any(|message| message.name == name);
                let node = self.0.iter().find(has).map_or(DEVICE, |one| one.node.as_str());
                OfMessage::Period { node, name }
            }
        };
        resolve(self.0, of).map_err(|(message, known)| NotFound {
            message,
            help: Some(proposal(of.name(), &known)),
        })
    }
}

/// The values that some formulas read from each message.
#[derive(Debug, Clone, Default)]
pub struct Reads {
    /// By speaker and index of the message.
    messages: BTreeMap<(usize, usize), Read>,
    values: Vec<(usize, f64)>,
    /// The moment of the last message.
    last: Timestamp,
}

/// What is read from a message.
#[derive(Debug, Clone, Default)]
struct Read {
    /// The values, and their numbers in the formulas.
    values: Vec<(Origin, usize)>,
    /// How many there were, and the moment of the last one.
    count: u64,
    last: Option<Timestamp>,
}

impl Reads {
    /// The values that `formulas` read from the messages of `speakers`.
    pub fn of<'a>(formulas: impl IntoIterator<Item = &'a Formula>, speakers: &[Speaker]) -> Self {
        let origins: Vec<Origin> = origins(speakers).collect();
        let mut messages = BTreeMap::new();
        for used in formulas.into_iter().flat_map(Formula::signals) {
            let Some(origin) = origins.get(used.index) else { continue };
            let read: &mut Read = messages.entry(origin.message()).or_default();
            if !read.values.contains(&(*origin, used.index)) {
                read.values.push((*origin, used.index));
            }
        }
        Self { messages, ..Self::default() }
    }

    /// The values in a message of a speaker, by their numbers in the formulas, and the moment from which they hold; `None` if
    /// no formula reads it. Of messages that arrive at one instant, as several packets of one write do, each counts: one
    /// like an earlier one holds from a nanosecond later.
    pub fn take(
        &mut self,
        now: Timestamp,
        speaker: usize,
        decoded: &Decoded<'_>,
    ) -> Option<(Timestamp, &[(usize, f64)])> {
        let Read { values, count, last } = self.messages.get_mut(&(speaker, decoded.message))?;
        let after = |last| last + Span::from_nanos(1);
        self.last = self.last.max(now).max(last.map_or(now, after));
        *last = Some(self.last);
        *count += 1;
        self.values.clear();
        let values =
            values.iter().map(|(origin, number)| Some((*number, origin.value(decoded, *count)?)));
        self.values.extend(values.flatten());
        Some((self.last, &self.values))
    }
}
