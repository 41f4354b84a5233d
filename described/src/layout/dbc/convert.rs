//! Converts the messages of a DBC to a layout, with notes on what is left out.

use super::lines::Lines;
use super::multiplexing::{Multiplexed, multiplexed};
use super::parts::{Of, Value};
use super::sending::sending;
use super::syntax::{
    ADDRESS, BIT_RATE_SWITCH, FRAME_FORMAT, LONG_MESSAGE, LONG_SIGNAL, MessageLine, SIGNAL_TYPE,
    START_VALUE, SignalLine, Syntax,
};
use super::{Note, ORPHANS, long_node, senders};
use crate::bits::BitField;
use crate::file::ByteOrder;
use crate::file::ProtectionTable;
use crate::layout::Sender;
use crate::layout::message::{Carrier, Message};
use crate::layout::multiplexing;
use crate::layout::number::{Coding, Scale};
use crate::layout::selection::{Carried, Selection};
use crate::layout::signal::{Signal, Storage};
use crate::place::Place;
use std::collections::BTreeMap;
use std::ops::Range;
use wire::can::{self, DATA_BYTES_MAX, FdFlags, Id, fd_length};
use wire::j1939::{self, Identifier};

/// Flag of an identifier with 29 bits.
const EXTENDED: u64 = 1 << 31;

/// A message, the nodes that send it, and its place in the text.
pub(super) struct Converted {
    pub(super) message: Message,
    pub(super) sent_by: Vec<String>,
    pub(super) at: Range<usize>,
}

/// The messages as a receiver sees them, and notes on the others.
pub(super) fn convert(file: &str, text: &str, syntax: &Syntax) -> (Vec<Converted>, Vec<Note>) {
    let lines = Lines::of(text);
    let mut converter = Converter { file, lines, syntax, notes: Vec::new() };
    let repetitions = converter.repetitions();
    let mut messages = Vec::new();
    for (message, repeated) in syntax.messages.iter().zip(repetitions) {
        if message.name == ORPHANS {
            continue;
        }
        match repeated.map_or_else(|| converter.message(message), Err) {
            Ok(converted) => {
                let senders = senders(syntax, message).map(|of| long_node(syntax, of).to_owned());
                let (sent_by, at) = (senders.collect(), message.at.clone());
                messages.push(Converted { message: converted, sent_by, at });
            }
            Err(why) => {
                let what = format!("{why}: the message is left out");
                converter.note(message, None, true, what);
            }
        }
    }
    (messages, converter.notes)
}

struct Converter<'a> {
    file: &'a str,
    lines: Lines,
    syntax: &'a Syntax,
    notes: Vec<Note>,
}

/// A signal that is kept, and its position among the lines of its message.
type Kept = (usize, Signal);

impl Converter<'_> {
    fn note(
        &mut self,
        message: &MessageLine,
        signal: Option<&SignalLine>,
        is_left_out: bool,
        what: String,
    ) {
        self.notes.push(Note {
            file: self.file.to_owned(),
            line: self.lines.number(signal.map_or(&message.at, |signal| &signal.at)),
            message: self.message_name(message).to_owned(),
            signal: signal.map(|signal| self.signal_name(message, signal).to_owned()),
            is_left_out,
            what,
        });
    }

    fn message_name<'a>(&'a self, message: &'a MessageLine) -> &'a str {
        let long = self.syntax.attribute(Of::Message(message.id), LONG_MESSAGE);
        long.and_then(Value::text).unwrap_or(&message.name)
    }

    fn signal_name<'a>(&'a self, message: &MessageLine, signal: &'a SignalLine) -> &'a str {
        let of = Of::Signal(message.id, signal.name.clone());
        self.syntax.attribute(of, LONG_SIGNAL).and_then(Value::text).unwrap_or(&signal.name)
    }

    /// For each message the reason for leaving it out if a later one has its identifier or its name.
    fn repetitions(&self) -> Vec<Option<String>> {
        let (mut by_id, mut by_name) = (BTreeMap::new(), BTreeMap::new());
        let mut reasons: Vec<_> = (self.syntax.messages.iter().rev())
            .map(|message| {
                let same_id = by_id.insert(message.id, message);
                let same_name = by_name.insert(self.message_name(message), message);
                let line = |other: &MessageLine| self.lines.number(&other.at);
                let of_id = |other: &MessageLine| {
                    format!("`{}` in line {} has the same identifier", other.name, line(other))
                };
                let of_name = |other| format!("line {} has the name again", line(other));
                same_id.map(of_id).or(same_name.map(of_name))
            })
            .collect();
        reasons.reverse();
        reasons
    }

    /// The message. Otherwise the reason for leaving it out.
    fn message(&mut self, message: &MessageLine) -> Result<Message, String> {
        let name = self.message_name(message).to_owned();
        let mut id = self.identifier(message)?;
        let group = self.group(message, &mut id);
        let carrier = self.carrier(message, id, group.is_some())?;
        let length = match carrier {
            Carrier::Parts { length, .. } | Carrier::Frame { length, .. } => length,
            _ => 0,
        };
        let of = Of::Message(message.id);
        let signals = self.signals(message, length);
        let name_of = |place: usize| self.signal_name(message, &message.signals[place]).to_owned();
        let (period, send) = sending(self.syntax, message, &signals, &name_of);
        let is_counter = |line: &&SignalLine| {
            let of = Of::Signal(message.id, line.name.clone());
            self.syntax.choice(of, SIGNAL_TYPE) == Some("MessageCounter")
        };
        let counter = message.signals.iter().find(is_counter);
        let doc = self.syntax.comments.get(&of).cloned().unwrap_or_default();
        let converted = Message::new(name, Sender::Host, carrier, signals);
        let mut converted = Message { send, period, doc, group, ..converted };
        if let Some(signal) = counter {
            let name = self.signal_name(message, signal).to_owned();
            let counted = converted.protect(&ProtectionTable::counting(name), &Place::file());
            if counted.is_err() {
                let what = "as the message's counter it has no use: it is a signal like others";
                self.note(message, Some(signal), false, what.to_owned());
            }
        }
        Ok(converted)
    }

    /// The carrier: a frame, of CAN FD if it has more bytes or the file specifies so, or the packets of J1939.
    fn carrier(&self, message: &MessageLine, id: Id, is_group: bool) -> Result<Carrier, String> {
        let of = Of::Message(message.id);
        let bytes = usize::try_from(message.bytes).unwrap_or(usize::MAX);
        if let (Id::Extended(id), true) = (id, is_group && bytes > DATA_BYTES_MAX) {
            return match bytes <= j1939::BYTES_MAX {
                true => Ok(Carrier::Parts { id, length: bytes }),
                false => Err(format!("it has {bytes} bytes, and J1939 1785 at most")),
            };
        }
        let format = self.syntax.choice(of.clone(), FRAME_FORMAT);
        if bytes <= DATA_BYTES_MAX && !format.is_some_and(|format| format.ends_with("_FD")) {
            return Ok(Carrier::Frame { id, length: bytes, fd: None });
        }
        let length = fd_length(bytes)
            .ok_or_else(|| format!("it has {bytes} bytes, and a CAN FD frame 64 at most"))?;
        // Default in Vector's files.
        let bit_rate_switch = self.syntax.choice(of, BIT_RATE_SWITCH) != Some("0");
        let fd = Some(FdFlags { bit_rate_switch, error_state: false });
        Ok(Carrier::Frame { id, length, fd })
    }

    /// The identifier's fields if it is one of J1939. If the file leaves the source open, it is the sender's address.
    fn group(&self, message: &MessageLine, id: &mut Id) -> Option<Identifier> {
        let format = self.syntax.choice(Of::Message(message.id), FRAME_FORMAT);
        let Id::Extended(extended) = id else { return None };
        if !format.is_some_and(|format| format.starts_with("J1939")) {
            return None;
        }
        let mut group = Identifier::from(*extended);
        let of = Of::Node(message.sender.clone());
        let address = self.syntax.attribute(of, ADDRESS).and_then(Value::number);
        if let Some(address) =
            address.filter(|address| (0.0..f64::from(j1939::NULL)).contains(address))
            && group.source == j1939::NULL
        {
            group.source = address as u8;
            *extended = group.id();
        }
        Some(group)
    }

    fn identifier(&mut self, message: &MessageLine) -> Result<Id, String> {
        let raw = u32::try_from(message.id & !EXTENDED).ok();
        let standard = raw.and_then(|raw| can::identifier(raw, false));
        let extended = raw.and_then(|raw| can::identifier(raw, true));
        if message.id & EXTENDED != 0 {
            return extended.ok_or_else(|| "its identifier has more than 29 bits".to_owned());
        }
        if let Some(standard) = standard {
            return Ok(standard);
        }
        let extended = extended.ok_or_else(|| "its identifier has more than 29 bits".to_owned())?;
        let what =
            "its identifier has more than 11 bits, and not bit 31: it is taken as one of 29 bits";
        self.note(message, None, false, what.to_owned());
        Ok(extended)
    }

    /// The signals of the message that fit; of two that share bits, the shorter one.
    fn signals(&mut self, message: &MessageLine, bytes: usize) -> Vec<Signal> {
        let selections = multiplexed(self.syntax, message);
        let mut kept: Vec<Kept> = Vec::new();
        for (place, signal) in message.signals.iter().enumerate() {
            let again = message.signals[..place].iter().any(|other| other.name == signal.name);
            let converted = match &selections[place] {
                Multiplexed::ByNothing(why) => Err(why.clone()),
                _ if again => Err("the message has a signal of this name already".to_owned()),
                _ => self.signal(message, signal, bytes),
            };
            let is_multiplexer = |signal: &SignalLine| signal.multiplexes;
            if signal.page.is_some() && !message.signals.iter().any(is_multiplexer) {
                let what = "the message has no multiplexer (`M`): it is taken as in each frame";
                self.note(message, Some(signal), false, what.to_owned());
            }
            match converted {
                Ok(converted) => kept.push((place, converted)),
                Err(why) => self.leave_out(message, signal, &why),
            }
        }
        self.widen_multiplexers(message, &mut kept, &selections);
        loop {
            let signals = placed(&kept, &selections);
            let Some((index, why)) = conflict(&signals, &kept, &selections) else {
                return signals;
            };
            let (place, _) = kept.remove(index);
            self.leave_out(message, &message.signals[place], &why);
        }
    }

    /// Extends the range of a multiplexer to that of its bits if its declared range lacks numbers used by its signals.
    fn widen_multiplexers(
        &mut self,
        message: &MessageLine,
        kept: &mut [Kept],
        selections: &[Multiplexed],
    ) {
        for selection in selections {
            let Multiplexed::By(multiplexer, numbers) = selection else { continue };
            let Some((place, signal)) = kept.iter_mut().find(|(place, _)| place == multiplexer)
            else {
                continue;
            };
            let ends = numbers.iter().flat_map(|range| [*range.start(), *range.end()]);
            let is_beyond = |number: &u64| {
                signal.reaches(*number) && signal.number_of(signal.selecting(*number)).is_none()
            };
            let Some(number) = ends.into_iter().find(is_beyond) else { continue };
            let (minimum, maximum) = (signal.minimum, signal.maximum);
            signal.widen();
            let what = format!(
                "its range, {minimum} to {maximum}, lacks the number {number} of its signals: it may be {} to {}",
                signal.minimum, signal.maximum
            );
            let place = *place;
            self.note(message, Some(&message.signals[place]), false, what);
        }
    }

    fn leave_out(&mut self, message: &MessageLine, signal: &SignalLine, why: &str) {
        self.note(message, Some(signal), true, format!("{why}: the signal is left out"));
    }

    /// The signal, as carried in each frame. Otherwise the reason for leaving it out.
    fn signal(
        &mut self,
        message: &MessageLine,
        signal: &SignalLine,
        bytes: usize,
    ) -> Result<Signal, String> {
        let key = (message.id, signal.name.clone());
        let of = Of::Signal(message.id, signal.name.clone());
        let order = if signal.is_big_endian { ByteOrder::Big } else { ByteOrder::Little };
        let (start, length) = (signal.start, signal.length);
        let field = BitField::new(order, start, length, bytes).ok_or_else(|| {
            format!(
                "its {length} bits from bit {start} do not lie in the {bytes} bytes of the message"
            )
        })?;
        let coding = match (self.syntax.kinds.get(&key), length) {
            (Some(1 | 2), 32) => Coding::Float32,
            (Some(1 | 2), 64) => Coding::Float64,
            (Some(1 | 2), bits) => {
                return Err(format!("it is a float of {bits} bits, and floats have 32 or 64"));
            }
            _ if signal.is_signed => Coding::Signed,
            _ => Coding::Unsigned,
        };
        let scale = Scale::new(signal.factor, signal.offset).ok_or_else(|| {
            format!("its factor is {} and its offset {}", signal.factor, signal.offset)
        })?;
        let (least, greatest) = coding.limits(field.length());
        let (minimum, maximum) = scale.range(least, greatest);
        let start = self.syntax.attribute(of.clone(), START_VALUE).and_then(Value::number);
        let name = self.signal_name(message, signal).to_owned();
        let storage = Storage::Bits { field, coding };
        let mut converted = Signal {
            unit: signal.unit.clone(),
            doc: self.syntax.comments.get(&of).cloned().unwrap_or_default(),
            multiplexes: signal.multiplexes,
            named_values: self.syntax.values.get(&key).cloned().unwrap_or_default(),
            // A start value is a number on the wire.
            start: start.filter(|raw| raw.is_finite()).map_or(0.0, |raw| scale.physical(raw)),
            ..Signal::new(name, (minimum, maximum), scale, storage)
        };
        let is_declared = signal.minimum != 0.0 || signal.maximum != 0.0;
        if is_declared && !converted.narrow(signal.minimum, signal.maximum) {
            let what = format!(
                "no value that its bits carry is in its range, {} to {}: it may be {minimum} to {maximum}",
                signal.minimum, signal.maximum
            );
            self.note(message, Some(signal), false, what);
        }
        converted.start = converted.nearest(converted.start);
        Ok(converted)
    }
}

/// The signals, with the positions of their multiplexers. A signal without its multiplexer is always carried.
fn placed(kept: &[Kept], selections: &[Multiplexed]) -> Vec<Signal> {
    let of = |(place, signal): &Kept| match &selections[*place] {
        Multiplexed::By(multiplexer, numbers) => {
            let multiplexer = kept.iter().position(|(other, _)| other == multiplexer);
            let carried = multiplexer.map(|multiplexer| {
                Carried::When(Selection { multiplexer, numbers: numbers.clone() })
            });
            Signal { carried: carried.unwrap_or(Carried::Always), ..signal.clone() }
        }
        _ => signal.clone(),
    };
    kept.iter().map(of).collect()
}

/// The first signal that conflicts with preceding ones, and the reason.
fn conflict(
    signals: &[Signal],
    kept: &[Kept],
    selections: &[Multiplexed],
) -> Option<(usize, String)> {
    let orphan = kept.iter().position(|(place, _)| match &selections[*place] {
        Multiplexed::By(multiplexer, _) => kept.iter().all(|(other, _)| other != multiplexer),
        _ => false,
    });
    if let Some(orphan) = orphan {
        return Some((orphan, "its multiplexer is left out".to_owned()));
    }
    for (index, signal) in signals.iter().enumerate() {
        let Carried::When(selection) = &signal.carried else { continue };
        let multiplexer = &signals[selection.multiplexer];
        if !selection.numbers.iter().any(|range| multiplexer.reaches(*range.start())) {
            let why = format!("the bits of `{}` cannot be {selection}", multiplexer.name);
            return Some((index, why));
        }
    }
    let (first, second) = multiplexing::overlap(signals)?;
    // Some files have one signal over all the bits that others divide.
    let is_whole = signals[first].bits() > signals[second].bits();
    let (out, other) = if is_whole { (first, second) } else { (second, first) };
    Some((out, format!("it has bits in common with `{}`", signals[other].name)))
}
