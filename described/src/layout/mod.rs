//! Messages and their signals: physical values to bytes, and back.

mod alike;
mod altered;
mod canopen;
mod checksum;
mod decoder;
mod diagnostic;
mod encoder;
mod frame_writer;
mod frames;
mod host;
mod message;
mod multiplexing;
mod names;
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

pub use dbc::{Dbc, DbcNode, Dbcs, NOBODY, dbc_text};
pub use decoder::Decoder;
pub use described_file::{SendKind, Sender, SignalValue};
pub use encoder::Encoder;
use frame_writer::FrameWriter;
use frames::{FrameReader, Identifiers};
pub use message::{Encoded, Message};
use names::{Names, Place};
pub use note::Note;
pub(crate) use number::{Coding, Scale};
#[cfg(test)]
pub(crate) use protected::tests::cells;
pub use selection::{Carried, Selection};
pub use send_rule::SendRule;
pub use signal::Signal;
use wire::device::Transmit;

use crate::canopen::Dictionary;
use crate::error::Read;
use crate::hint;
use crate::protection::Verdict;
use miette::Diagnostic;
use std::collections::BTreeSet;
use std::sync::Arc;
use thiserror::Error;
use wire::j1939;
use wire::serial::SerialSettings;

/// The medium of a layout.
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
    names: Arc<Names>,
    /// One per message.
    frames: Arc<[FrameReader]>,
    /// One per message; `None` if its frames differ in the signals that they carry.
    writers: Arc<[Option<FrameWriter>]>,
    notes: Arc<[Note]>,
    /// The objects of a CANopen device.
    dictionary: Option<Arc<Dictionary>>,
}

/// A received message.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decoded<'a> {
    /// Its index in [`Layout::messages`].
    pub message: usize,
    /// Its definition.
    pub form: &'a Message,
    /// One value per signal, in the signal's unit; `None` if this frame does not carry it or has a wrong checksum: a
    /// receiver discards it.
    pub values: &'a [Option<f64>],
    /// Verdict on its counter and its checksum, if it has any.
    pub verdict: Option<Verdict>,
}

impl Decoded<'_> {
    /// True if a receiver uses it: it is unprotected, or counter and checksum are right.
    pub const fn is_sound(&self) -> bool {
        match self.verdict {
            Some(verdict) => verdict.is_sound(),
            None => true,
        }
    }

    /// The positions of the signals with a value that no sender may send.
    pub fn out_of_range(&self) -> impl Iterator<Item = usize> {
        let is_out = |(value, signal): (&Option<f64>, &Signal)| {
            value.is_some_and(|value| signal.is_out_of_range(value))
        };
        let each = self.values.iter().zip(&self.form.signals).enumerate();
        each.filter(move |(_, one)| is_out(*one)).map(|(place, _)| place)
    }
}

/// Reason why values cannot be encoded.
#[derive(Debug, Clone, PartialEq, Error, Diagnostic)]
pub enum EncodeError {
    /// The layout has no such message.
    #[error("failed to encode message number {0}: the layout has fewer")]
    NoMessage(usize),
    /// The number of values is wrong.
    #[error("failed to encode `{message}`: it has {expected} signals, and {found} values came")]
    Count {
        /// The message.
        message: String,
        /// Number of signals.
        expected: usize,
        /// Number of values.
        found: usize,
    },
    /// A value that the signal cannot have.
    #[error(
        "`{signal}` cannot be {value}{0}: its range is {minimum} to {maximum}{0}",
        spaced(unit)
    )]
    OutOfRange {
        /// The signal, with its message.
        signal: String,
        /// The value.
        value: f64,
        /// The smallest possible value.
        minimum: f64,
        /// The largest possible value.
        maximum: f64,
        /// Unit of all three.
        unit: String,
    },
    /// It does not fit into one frame.
    #[error("`{message}` is longer than a frame: it goes in parts")]
    InParts {
        /// The message.
        message: String,
    },
    /// A line of text that exceeds the maximum packet length.
    #[error("failed to encode `{message}`: it is longer than {} bytes", wire::packet::BYTES_MAX)]
    TooLong {
        /// The message.
        message: String,
    },
}

/// Reason why a name does not identify one signal.
#[derive(Debug, Clone, PartialEq, Eq, Error, Diagnostic)]
pub enum SignalName {
    /// No message has a signal of this name.
    #[error("no signal `{name}`")]
    Unknown {
        /// The name.
        name: String,
        /// A suggestion.
        #[help]
        help: String,
    },
    /// Several messages have a signal of this name.
    #[error("several messages have a signal `{name}`")]
    Ambiguous {
        /// The name.
        name: String,
        /// The candidates.
        #[help]
        help: String,
    },
}

impl SignalName {
    /// The suggested name.
    pub fn advice(&self) -> &str {
        match self {
            Self::Unknown { help, .. } | Self::Ambiguous { help, .. } => help,
        }
    }
}

/// A unit as it follows a number.
pub(crate) fn spaced(unit: &str) -> String {
    if unit.is_empty() { String::new() } else { format!(" {unit}") }
}

/// The only one of `places`.
fn only(places: &[Place]) -> Option<Place> {
    match places {
        [only] => Some(*only),
        _ => None,
    }
}

impl Layout {
    pub(crate) fn new(medium: Medium, messages: Vec<Message>) -> Self {
        Self {
            medium,
            identifiers: Arc::new(Identifiers::of(&messages)),
            names: Arc::new(Names::of(&messages)),
            frames: messages.iter().map(FrameReader::of).collect(),
            writers: messages.iter().map(FrameWriter::of).collect(),
            messages: messages.into(),
            notes: Arc::default(),
            dictionary: None,
        }
    }

    fn noting(self, notes: Vec<Note>) -> Self {
        Self { notes: notes.into(), ..self }
    }

    /// Parts of the file that cannot be used as written, or not at all.
    pub fn notes(&self) -> &[Note] {
        &self.notes
    }

    /// The note that explains why a message or a signal of this name was left out: `Status`, `Temperature` or
    /// `Status.Temperature`.
    pub fn left_out(&self, name: &str) -> Option<&Note> {
        self.notes.iter().find(|note| note.leaves_out(name))
    }

    /// The layout with other periods and start values, set by `change` for each message.
    pub(crate) fn changed(self, mut change: impl FnMut(usize, &mut Message) -> Read) -> Read<Self> {
        let mut messages = self.messages.to_vec();
        for (index, message) in messages.iter_mut().enumerate() {
            change(index, message)?;
        }
        let writers = messages.iter().map(FrameWriter::of).collect();
        Ok(Self { writers, messages: messages.into(), ..self })
    }

    /// Its first message that needs CAN FD.
    pub fn fd_message(&self) -> Option<&Message> {
        self.messages.iter().find(|message| message.is_fd())
    }

    /// The medium of the messages.
    pub const fn medium(&self) -> Medium {
        self.medium
    }

    /// The messages, in the order of the file.
    pub fn messages(&self) -> &[Message] {
        &self.messages
    }

    /// The index of the message with this name.
    pub fn find(&self, message: &str) -> Option<usize> {
        self.names.message(message)
    }

    /// The index of the signal's message, and the position of the signal in it: `Temperature` if only one message has
    /// it, otherwise `Status.Temperature`. [`Layout::resolve`] explains a failure.
    pub fn signal(&self, name: &str) -> Option<Place> {
        only(&self.called(name, None))
    }

    /// As [`Layout::signal`], among the messages of one sender.
    pub fn sent_signal(&self, sender: Sender, name: &str) -> Option<Place> {
        only(&self.called(name, Some(sender)))
    }

    /// As [`Layout::signal`], with the nearest names if there is no such signal.
    pub fn resolve(&self, name: &str) -> Result<Place, SignalName> {
        self.resolve_among(name, None)
    }

    /// As [`Layout::resolve`], among the messages of one sender.
    pub(crate) fn resolve_among(
        &self,
        name: &str,
        sender: Option<Sender>,
    ) -> Result<Place, SignalName> {
        let found = self.called(name, sender);
        if let Some(place) = only(&found) {
            return Ok(place);
        }
        if found.is_empty() {
            let help = match self.left_out(name) {
                Some(note) => note.to_string(),
                None => hint::proposal(name, &self.known(name.contains('.'), sender)),
            };
            return Err(SignalName::Unknown { name: name.to_owned(), help });
        }
        let each = found.into_iter().map(|(message, signal)| {
            let message = &self.messages[message];
            format!("`{}.{}`", message.name, message.signals[signal].name)
        });
        let help = format!("say which: {}", each.collect::<Vec<_>>().join(" or "));
        Err(SignalName::Ambiguous { name: name.to_owned(), help })
    }

    /// The places of all signals of this name in the messages of one sender, or of both.
    fn called(&self, name: &str, sender: Option<Sender>) -> Vec<Place> {
        let mut places = self.names.signals(name, &self.messages);
        places.retain(|(message, _)| self.is_of(*message, sender));
        places
    }

    fn is_of(&self, message: usize, sender: Option<Sender>) -> bool {
        sender.is_none_or(|one| self.messages[message].sender == one)
    }

    /// The names of all signals of one sender, or of both; in full, with their messages.
    pub(crate) fn known(&self, in_full: bool, sender: Option<Sender>) -> Vec<String> {
        let messages = self.messages.iter().enumerate();
        let sent = messages.filter(|(index, _)| self.is_of(*index, sender));
        let signals = sent.flat_map(|(_, message)| {
            message.signals.iter().map(move |signal| match in_full {
                true => format!("{}.{}", message.name, signal.name),
                false => signal.name.clone(),
            })
        });
        signals.collect()
    }
    /// The message with these values, one per signal and in its unit. Values of signals that a multiplexed frame does
    /// not carry are ignored. A counter and a checksum among the signals have the given values; an
    /// [`Outbox`](crate::Outbox) computes them.
    ///
    /// # Errors
    /// See [`EncodeError`]; also for a message that is sent in parts.
    pub fn encode(&self, message: usize, values: &[f64]) -> Result<Transmit, EncodeError> {
        let whole = self.encoded(message, values)?.whole();
        whole.ok_or_else(|| EncodeError::InParts { message: self.messages[message].name.clone() })
    }

    fn encoded(&self, message: usize, values: &[f64]) -> Result<Encoded, EncodeError> {
        let found = self.messages.get(message).ok_or(EncodeError::NoMessage(message))?;
        match self.writers[message].as_ref().and_then(|writer| writer.write(values)) {
            Some(frame) => Ok(Encoded::Whole(Transmit::Frame(frame))),
            // No writer, or it refused: this call encodes the message or reports the reason.
            None => found.encode(values, None),
        }
    }

    /// The writer for frames of an unprotected message; `None` if it has no writer.
    #[inline]
    fn plain_writer(&self, message: usize) -> Option<&FrameWriter> {
        self.writers.get(message)?.as_ref().filter(|writer| !writer.is_protected())
    }

    /// The addresses from which `sender` sends and answers; `None` without parameter groups of J1939, which may come in parts.
    pub(crate) fn addresses(&self, sender: Sender) -> Option<BTreeSet<u8>> {
        if self.messages.iter().all(|message| message.group.is_none()) {
            return None;
        }
        let sent = self.messages.iter().filter(|message| message.sender == sender);
        let addresses = sent.filter_map(Message::group).map(|group| group.source);
        Some(addresses.filter(|address| *address < j1939::NULL).collect())
    }

    /// A decoder for all messages, from any sender.
    pub fn decoder(&self) -> Decoder {
        Decoder::new(self.clone(), None)
    }

    /// A decoder only for messages of `sender`, as at the other end of a serial line.
    pub fn decoder_for(&self, sender: Sender) -> Decoder {
        Decoder::new(self.clone(), Some(sender))
    }
}
