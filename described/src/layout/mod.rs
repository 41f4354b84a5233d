//! Messages and their signals: physical values to bytes, and back.

mod altered;
mod bits;
mod checksum;
mod decoder;
mod encoder;
mod frame_writer;
mod frames;
mod message;
mod note;
mod number;
mod printed;
mod protected;
mod selection;
mod send_rule;
mod signal;
#[cfg(test)]
pub(crate) mod tests;
mod text;

mod dbc;
mod table;

pub(crate) use bits::BitField;
pub use bits::{ByteOrder, SIGNAL_BITS_MAX};
pub use dbc::{DbcNode, NOBODY, dbc_nodes, dbc_text};
pub use decoder::Decoder;
pub use encoder::{Encoded, Encoder};
use frame_writer::FrameWriter;
use frames::{FrameReader, Identifiers};
pub use message::{Message, Sender};
pub use note::Note;
#[cfg(test)]
pub(crate) use protected::tests::cells;
pub use selection::{Carried, Selection};
pub use send_rule::{SendKind, SendRule};
pub use signal::Signal;
use wire::device::Transmit;

use crate::error::Mistake;
use crate::hint;
use crate::protection::Verdict;
use miette::Diagnostic;
use std::sync::Arc;
use thiserror::Error;
use wire::serial::SerialSettings;

/// What carries the messages of a layout.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Medium {
    /// Classic CAN.
    Can,
    /// A serial line with these settings.
    Serial(SerialSettings),
}

/// All messages between a device and its host. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Layout {
    medium: Medium,
    messages: Arc<[Message]>,
    identifiers: Arc<Identifiers>,
    /// One a message.
    frames: Arc<[FrameReader]>,
    /// One a message; none of those whose frames differ in what they carry.
    writers: Arc<[Option<FrameWriter>]>,
    notes: Arc<[Note]>,
}

/// A message that was received.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decoded<'a> {
    /// Its place in [`Layout::messages`].
    pub message: usize,
    /// What it is.
    pub form: &'a Message,
    /// One value a signal, in the signal's unit; `None` where this frame does not carry it.
    pub values: &'a [Option<f64>],
    /// What its counter and its checksum say, where it is protected by any.
    pub verdict: Option<Verdict>,
}

impl Decoded<'_> {
    /// A receiver uses it: nothing protects it, or counter and checksum are right.
    pub const fn is_sound(&self) -> bool {
        match self.verdict {
            Some(verdict) => verdict.is_sound(),
            None => true,
        }
    }

    /// The places of the signals that have a value which no sender may say.
    pub fn out_of_range(&self) -> impl Iterator<Item = usize> {
        let is_out = |(value, signal): (&Option<f64>, &Signal)| {
            value.is_some_and(|value| signal.is_out_of_range(value))
        };
        let each = self.values.iter().zip(&self.form.signals).enumerate();
        each.filter(move |(_, one)| is_out(*one)).map(|(place, _)| place)
    }
}

/// Why values do not become a message.
#[derive(Debug, Clone, PartialEq, Error, Diagnostic)]
pub enum EncodeError {
    /// The layout has no such message.
    #[error("failed to encode message number {0}: the layout has fewer")]
    NoMessage(usize),
    /// A value too many or too few.
    #[error("failed to encode `{message}`: it has {expected} signals, and {found} values came")]
    Count {
        /// The message.
        message: String,
        /// How many signals it has.
        expected: usize,
        /// How many values there were.
        found: usize,
    },
    /// A value that the signal cannot have.
    #[error("`{signal}` cannot be {value}{}: it goes from {minimum} to {maximum}", spaced(unit))]
    OutOfRange {
        /// The signal, with its message.
        signal: String,
        /// The value.
        value: f64,
        /// The least that it can have.
        minimum: f64,
        /// The greatest that it can have.
        maximum: f64,
        /// Unit of all three.
        unit: String,
    },
    /// It has no frame of its own.
    #[error("`{message}` is longer than a frame: it goes in parts")]
    InParts {
        /// The message.
        message: String,
    },
    /// A line of text that is longer than what is sent at once.
    #[error("failed to encode `{message}`: it is longer than {} bytes", wire::packet::BYTES_MAX)]
    TooLong {
        /// The message.
        message: String,
    },
}

/// Why a name is not that of one signal.
#[derive(Debug, Clone, PartialEq, Eq, Error, Diagnostic)]
pub enum SignalName {
    /// No message has it.
    #[error("no signal `{name}`")]
    Unknown {
        /// The name.
        name: String,
        /// What was perhaps meant.
        #[help]
        help: String,
    },
    /// Several messages have one of this name.
    #[error("several messages have a signal `{name}`")]
    Ambiguous {
        /// The name.
        name: String,
        /// Which are meant.
        #[help]
        help: String,
    },
}

impl SignalName {
    /// What to write instead.
    pub fn advice(&self) -> &str {
        match self {
            Self::Unknown { help, .. } | Self::Ambiguous { help, .. } => help,
        }
    }
}

fn spaced(unit: &str) -> String {
    if unit.is_empty() { String::new() } else { format!(" {unit}") }
}

impl Layout {
    pub(crate) fn new(medium: Medium, messages: Vec<Message>) -> Self {
        Self {
            medium,
            identifiers: Arc::new(Identifiers::of(&messages)),
            frames: messages.iter().map(FrameReader::of).collect(),
            writers: messages.iter().map(FrameWriter::of).collect(),
            messages: messages.into(),
            notes: Arc::default(),
        }
    }

    fn noting(self, notes: Vec<Note>) -> Self {
        Self { notes: notes.into(), ..self }
    }

    /// What its file says that cannot be used as it is, or not at all.
    pub fn notes(&self) -> &[Note] {
        &self.notes
    }

    /// The note by which a message or a signal of this name was left out: `Status`, `Temperature` or
    /// `Status.Temperature`.
    pub fn left_out(&self, name: &str) -> Option<&Note> {
        self.notes.iter().find(|note| note.leaves_out(name))
    }

    /// The same with other periods and starts: what `change` makes of each message.
    pub(crate) fn changed(
        self,
        mut change: impl FnMut(usize, &mut Message) -> Result<(), Mistake>,
    ) -> Result<Self, Mistake> {
        let mut messages = self.messages.to_vec();
        for (index, message) in messages.iter_mut().enumerate() {
            change(index, message)?;
        }
        let writers = messages.iter().map(FrameWriter::of).collect();
        Ok(Self { writers, messages: messages.into(), ..self })
    }

    /// Its first message that only CAN FD carries.
    pub fn fd_message(&self) -> Option<&Message> {
        self.messages.iter().find(|message| message.is_fd())
    }

    /// What carries the messages.
    pub const fn medium(&self) -> Medium {
        self.medium
    }

    /// The messages, in the order of the file.
    pub fn messages(&self) -> &[Message] {
        &self.messages
    }

    /// The place of the message with this name.
    pub fn find(&self, message: &str) -> Option<usize> {
        self.messages.iter().position(|known| known.name == message)
    }

    /// The places of the signal's message, and of the signal in it: `Temperature` where one message has
    /// it, or `Status.Temperature`. [`Layout::resolve`] says why there is none.
    pub fn signal(&self, name: &str) -> Option<(usize, usize)> {
        self.resolve(name).ok()
    }

    /// As [`Layout::signal`], among the messages of one sender.
    pub fn sent_signal(&self, sender: Sender, name: &str) -> Option<(usize, usize)> {
        self.resolve_among(name, Some(sender)).ok()
    }

    /// As [`Layout::signal`], with the nearest names where there is no such signal.
    pub fn resolve(&self, name: &str) -> Result<(usize, usize), SignalName> {
        self.resolve_among(name, None)
    }

    /// As [`Layout::resolve`], among the messages of one sender.
    pub(crate) fn resolve_among(
        &self,
        name: &str,
        sender: Option<Sender>,
    ) -> Result<(usize, usize), SignalName> {
        let full = name.contains('.');
        let called = |message: usize, signal: &Signal| match full {
            true => format!("{}.{}", self.messages[message].name, signal.name),
            false => signal.name.clone(),
        };
        let places = || {
            let sent =
                |message: usize| sender.is_none_or(|one| self.messages[message].sender == one);
            self.places().filter(move |(message, ..)| sent(*message))
        };
        let found: Vec<_> = places().filter(|(m, _, signal)| called(*m, signal) == name).collect();
        match found.as_slice() {
            [] => {
                let known: Vec<String> = places().map(|(m, _, signal)| called(m, signal)).collect();
                let help = match self.left_out(name) {
                    Some(note) => note.to_string(),
                    None => hint::proposal(name, &known),
                };
                Err(SignalName::Unknown { name: name.to_owned(), help })
            }
            [(message, signal, _)] => Ok((*message, *signal)),
            several => {
                let each = several.iter().map(|(message, _, signal)| {
                    format!("`{}.{}`", self.messages[*message].name, signal.name)
                });
                let help = format!("say which: {}", each.collect::<Vec<_>>().join(" or "));
                Err(SignalName::Ambiguous { name: name.to_owned(), help })
            }
        }
    }

    /// Every signal, with the places of its message and of itself.
    fn places(&self) -> impl Iterator<Item = (usize, usize, &Signal)> {
        self.messages.iter().enumerate().flat_map(|(message, known)| {
            known.signals.iter().enumerate().map(move |(signal, known)| (message, signal, known))
        })
    }

    /// The message with these values, one a signal and in its unit. Values of signals that a
    /// multiplexed frame does not carry are not looked at. A counter and a checksum among the signals are their values
    /// here; an [`Outbox`](crate::Outbox) puts in what they have to be.
    ///
    /// # Errors
    /// As [`EncodeError`] says; of a message that goes in parts too.
    pub fn encode(&self, message: usize, values: &[f64]) -> Result<Transmit, EncodeError> {
        let whole = self.encoded(message, values)?.whole();
        whole.ok_or_else(|| EncodeError::InParts { message: self.messages[message].name.clone() })
    }

    fn encoded(&self, message: usize, values: &[f64]) -> Result<Encoded, EncodeError> {
        let found = self.messages.get(message).ok_or(EncodeError::NoMessage(message))?;
        match self.writers[message].as_ref().and_then(|writer| writer.write(values)) {
            Some(frame) => Ok(Encoded::Whole(Transmit::Frame(frame))),
            // It is none, or says why it is none.
            None => found.encode(values, None),
        }
    }

    /// What writes the frames of a message in which its sender's memory has no part; `None` where there is none.
    #[inline]
    fn plain_writer(&self, message: usize) -> Option<&FrameWriter> {
        self.writers.get(message)?.as_ref().filter(|writer| !writer.is_protected())
    }

    /// A decoder that hears all messages, whoever sends them.
    pub fn decoder(&self) -> Decoder {
        Decoder::new(self.clone(), None)
    }

    /// A decoder that hears only what `sender` sends, as the other end of a serial line does.
    pub fn decoder_for(&self, sender: Sender) -> Decoder {
        Decoder::new(self.clone(), Some(sender))
    }
}
