//! Layouts from DBC files.

use super::bits::{BitField, ByteOrder};
use super::message::{Carrier, Message, Sender};
use super::number::{Coding, Scale};
use super::signal::{Carried, Signal, Storage};
use super::{Layout, Medium};
use crate::error::DescriptionError;
use crate::hint;
use can_dbc::{
    AttributeValue, Dbc, DbcError, ExtendedMultiplex, MessageId, MultiplexIndicator, NumericValue,
    SignalExtendedValueType, ValueType,
};
use std::ops::Range;
use wire::can::{DATA_BYTES_MAX, ExtendedId, Id, StandardId};
use wire::time::Span;

/// Holds signals that are in no message; Vector's tools write it.
const ORPHANS: &str = "VECTOR__INDEPENDENT_SIG_MSG";

/// Attributes in wide use (Vector's "interaction layer").
const CYCLE_TIME_MS: &str = "GenMsgCycleTime";
const START_VALUE: &str = "GenSigStartValue";

impl Layout {
    /// The layout of a DBC: `node` is the device, which sends that node's messages and hears the others.
    ///
    /// # Errors
    /// Where the text is no DBC, has no such node, and for what is not supported, by name: messages of
    /// more than 8 bytes, multiplexed multiplexers, and signals that overlap.
    pub fn from_dbc(file: &str, text: &str, node: &str) -> Result<Self, DescriptionError> {
        let dbc = parsed(file, text)?;
        let nodes: Vec<&str> = dbc.nodes.iter().map(|known| known.0.as_str()).collect();
        if !nodes.contains(&node) {
            let at = line_with(text, |line| line.starts_with("BU_")).unwrap_or(0..0);
            return Err(DescriptionError::new(file, text, at, format!("no node `{node}`"))
                .with_help(Some(hint::proposal(node, &nodes))));
        }
        Ok(Self::new(Medium::Can, messages_of(file, text, &dbc, &|of| of == node)?))
    }

    /// The layout of one or several DBCs, each by its name and text, for somebody who sends the messages of several nodes, or
    /// of none that has a name: of those that `is_ours` says yes to. What two files define alike is one message.
    ///
    /// # Errors
    /// As [`Layout::from_dbc`], but for the node; and where two files define a message or an identifier differently.
    pub fn from_dbcs(
        files: &[(&str, &str)],
        is_ours: &dyn Fn(&str) -> bool,
    ) -> Result<Self, DescriptionError> {
        let mut messages: Vec<Message> = Vec::new();
        let mut origins = Vec::new();
        for (file, text) in files {
            for message in messages_of(file, text, &parsed(file, text)?, is_ours)? {
                let (name, id) = (&message.name, message.can_id());
                let is_it = |known: &Message| known.name == *name || known.can_id() == id;
                let Some(place) = messages.iter().position(is_it) else {
                    messages.push(message);
                    origins.push((file, text));
                    continue;
                };
                let Some(what) = difference(&messages[place], &message) else { continue };
                let (other, text_of_other) = origins[place];
                let before = line_of(text_of_other, &messages[place].name).start;
                let line = text_of_other[..before].lines().count() + 1;
                let known = &messages[place].name;
                let message =
                    format!("`{name}` and `{known}` in {other}, line {line}, have {what}");
                let help = "make the two the same, or take one out of a copy of its file";
                return Err(Refusal::message(message, help).located(file, text, name));
            }
        }
        Ok(Self::new(Medium::Can, messages))
    }
}

fn messages_of(
    file: &str,
    text: &str,
    dbc: &Dbc,
    is_ours: &dyn Fn(&str) -> bool,
) -> Result<Vec<Message>, DescriptionError> {
    let mut messages: Vec<Message> = Vec::new();
    for message in dbc.messages.iter().filter(|message| message.name != ORPHANS) {
        let converted = written_id(text, &message.name)
            .and_then(|written| convert(dbc, message, written, is_ours))
            .and_then(|converted| distinct(&messages, converted))
            .map_err(|refusal| refusal.located(file, text, &message.name))?;
        messages.push(converted);
    }
    Ok(messages)
}

/// What two definitions of a message do not agree on, but for their comments.
fn difference(one: &Message, other: &Message) -> Option<String> {
    let lacks = |of: &Message, signal: &Signal| {
        !of.signals
            .iter()
            .any(|known| Signal { doc: signal.doc.clone(), ..known.clone() } == *signal)
    };
    let apart = [
        (one.name != other.name, "one identifier"),
        (one.can_id() != other.can_id(), "one name and two identifiers"),
        (one.carrier != other.carrier, "one identifier and two lengths"),
        (one.sender != other.sender, "one identifier and two senders"),
        (one.period != other.period, "one identifier and two cycle times"),
    ];
    let what = apart.iter().find(|(differs, _)| *differs).map(|(_, what)| (*what).to_owned());
    what.or_else(|| {
        let ours = one.signals.iter().find(|signal| lacks(other, signal));
        let signal = ours.or_else(|| other.signals.iter().find(|signal| lacks(one, signal)))?;
        Some(format!("one identifier and two definitions of `{}`", signal.name))
    })
}

fn parsed(file: &str, text: &str) -> Result<Dbc, DescriptionError> {
    Dbc::try_from(text).map_err(|error| not_parsed(file, text, &error))
}

/// Why a message is not taken.
struct Refusal {
    signal: Option<String>,
    message: String,
    help: &'static str,
}

impl Refusal {
    fn message(message: String, help: &'static str) -> Self {
        Self { signal: None, message, help }
    }

    fn signal(signal: &can_dbc::Signal, message: String, help: &'static str) -> Self {
        Self { signal: Some(signal.name.clone()), message, help }
    }

    fn located(self, file: &str, text: &str, message: &str) -> DescriptionError {
        let begin = line_of(text, message);
        let at = self.signal.and_then(|name| {
            let after = text.get(begin.end..)?;
            let named = format!("SG_ {name} ");
            let line = line_with(after, |line| line.trim_start().starts_with(&named))?;
            Some(begin.end + line.start..begin.end + line.end)
        });
        DescriptionError::new(file, text, at.unwrap_or(begin), self.message)
            .with_help(Some(self.help.to_owned()))
    }
}

/// The first line of a message.
fn line_of(text: &str, message: &str) -> Range<usize> {
    line_with(text, |line| head(line).is_some_and(|(_, name)| name == message)).unwrap_or(0..0)
}

/// The identifier and the name in the first line of a message.
fn head(line: &str) -> Option<(&str, &str)> {
    let mut words = line.split_ascii_whitespace().filter(|word| *word != ":");
    let (section, id, name) = (words.next()?, words.next()?, words.next()?);
    (section == "BO_").then(|| (id, name.trim_end_matches(':')))
}

/// The identifier as the file writes it: the parser keeps the lowest 16 bits of one without bit 31.
fn written_id(text: &str, name: &str) -> Result<u32, Refusal> {
    let written = text.lines().filter_map(head).find(|(_, known)| *known == name);
    written.and_then(|(id, _)| id.parse().ok()).ok_or_else(|| {
        Refusal::message(
            format!("the identifier of `{name}` is not on a line with its name"),
            "a message begins with `BO_ IDENTIFIER NAME: BYTES NODE`",
        )
    })
}

/// The message, unless another has its name or its identifier.
fn distinct(known: &[Message], message: Message) -> Result<Message, Refusal> {
    let same_name = known.iter().any(|other| other.name == message.name);
    match known.iter().find(|other| other.can_id() == message.can_id()) {
        Some(other) => Err(Refusal::message(
            format!("`{}` and `{}` have one identifier", other.name, message.name),
            "take one of the two out of a copy of the file",
        )),
        None if same_name => Err(Refusal::message(
            format!("two messages have the name `{}`", message.name),
            "rename one of the two in a copy of the file",
        )),
        None => Ok(message),
    }
}

fn convert(
    dbc: &Dbc,
    message: &can_dbc::Message,
    written: u32,
    is_ours: &dyn Fn(&str) -> bool,
) -> Result<Message, Refusal> {
    let name = &message.name;
    let id = match message.id {
        MessageId::Standard(_) => {
            u16::try_from(written).ok().and_then(StandardId::new).map(Id::Standard)
        }
        MessageId::Extended(raw) => ExtendedId::new(raw).map(Id::Extended),
    };
    let id = id.ok_or_else(|| {
        Refusal::message(
            format!("the identifier of `{name}` has more than 11 bits"),
            "add 2147483648 (bit 31) to an identifier of 29 bits",
        )
    })?;
    let length = usize::try_from(message.size).unwrap_or(usize::MAX);
    if length > DATA_BYTES_MAX {
        return Err(Refusal::message(
            format!("`{name}` has {length} bytes, and a classic CAN frame 8 at most"),
            "CAN FD is not supported: take the message out of a copy of the file",
        ));
    }
    let also_sent = dbc
        .message_transmitters
        .iter()
        .any(|also| also.message_id == message.id && also.transmitter.iter().any(|of| is_ours(of)));
    let sent = message.transmitter.as_deref().is_some_and(is_ours) || also_sent;
    let signals = message
        .signals
        .iter()
        .map(|signal| convert_signal(dbc, message, signal, length))
        .collect::<Result<Vec<_>, _>>()?;
    let period_ms = dbc.resolved_message_attribute(message.id, CYCLE_TIME_MS).and_then(float);
    let converted = Message {
        name: name.clone(),
        sender: if sent { Sender::Device } else { Sender::Host },
        period: period_ms.filter(|ms| *ms > 0.0).map(|ms| Span::from_secs_f64(ms / 1e3)),
        signals,
        doc: dbc.message_comment(message.id).unwrap_or_default().to_owned(),
        carrier: Carrier::Frame { id, length },
    };
    let multiplexers = converted.signals.iter().filter(|s| s.carried == Carried::Multiplexer);
    let multiplexed = converted.signals.iter().any(|s| matches!(s.carried, Carried::When(_)));
    match multiplexers.count() {
        0 if multiplexed => Err(Refusal::message(
            format!("`{name}` has multiplexed signals and no multiplexer"),
            "mark the signal that selects with `M`",
        )),
        0 | 1 => Ok(()),
        _ => Err(Refusal::message(
            format!("`{name}` has more than one multiplexer"),
            "extended multiplexing is not supported: describe each frame as a [[message]]",
        )),
    }?;
    if let Some((one, another)) = converted.overlap() {
        let message = format!("`{}` and `{}` have bits in common", one.name, another.name);
        let help = "each bit belongs to one signal, or to several of other multiplexer values";
        return Err(Refusal { signal: Some(another.name.clone()), message, help });
    }
    Ok(converted)
}

fn convert_signal(
    dbc: &Dbc,
    message: &can_dbc::Message,
    signal: &can_dbc::Signal,
    bytes: usize,
) -> Result<Signal, Refusal> {
    let name = &signal.name;
    let refuse = |what: String, help| Refusal::signal(signal, what, help);
    let order = match signal.byte_order {
        can_dbc::ByteOrder::LittleEndian => ByteOrder::Little,
        can_dbc::ByteOrder::BigEndian => ByteOrder::Big,
    };
    let field = BitField::new(order, signal.start_bit, signal.size, bytes).ok_or_else(|| {
        refuse(
            format!("`{name}` does not lie in the {bytes} bytes of `{}`", message.name),
            "with @0 (Motorola) the start is the most significant bit, with @1 the least",
        )
    })?;
    let coding = match dbc.extended_value_type_for_signal(message.id, name) {
        Some(SignalExtendedValueType::IEEEfloat32Bit) if signal.size == 32 => Coding::Float32,
        Some(SignalExtendedValueType::IEEEdouble64bit) if signal.size == 64 => Coding::Float64,
        None | Some(SignalExtendedValueType::SignedOrUnsignedInteger) => match signal.value_type {
            ValueType::Signed => Coding::Signed,
            ValueType::Unsigned => Coding::Unsigned,
        },
        Some(_) => {
            let what = format!("`{name}` is a float of {} bits", signal.size);
            return Err(refuse(what, "SIG_VALTYPE_ 1 has 32 bits, and 2 has 64"));
        }
    };
    let scale = Scale::new(signal.factor, signal.offset).ok_or_else(|| {
        refuse(format!("the factor of `{name}` is {}", signal.factor), "a factor is not zero")
    })?;
    let (least, greatest) = coding.limits(field.length());
    let (minimum, maximum) = scale.range(least, greatest);
    let (declared_minimum, declared_maximum) = (number(&signal.min), number(&signal.max));
    let (minimum, maximum) = if declared_minimum == 0.0 && declared_maximum == 0.0 {
        (minimum, maximum)
    } else {
        (minimum.max(declared_minimum), maximum.min(declared_maximum))
    };
    if minimum > maximum {
        let what = format!("`{name}` goes from {declared_minimum} to {declared_maximum}");
        return Err(refuse(what, "no value that its bits carry is in that range"));
    }
    let start = dbc.resolved_signal_attribute(message.id, name, START_VALUE).and_then(float);
    let values = dbc.value_descriptions_for_signal(message.id, name).unwrap_or_default();
    Ok(Signal {
        name: name.clone(),
        unit: signal.unit.clone(),
        minimum,
        maximum,
        doc: dbc.signal_comment(message.id, name).unwrap_or_default().to_owned(),
        carried: carried(dbc, message.id, signal)?,
        named_values: values.iter().map(|v| (v.id, v.description.clone())).collect(),
        // A start value is a number on the wire.
        start: start.map_or(0.0, |raw| scale.physical(raw)).clamp(minimum, maximum),
        scale,
        storage: Storage::Bits { field, coding },
    })
}

fn carried(dbc: &Dbc, message: MessageId, signal: &can_dbc::Signal) -> Result<Carried, Refusal> {
    let carried = match signal.multiplexer_indicator {
        MultiplexIndicator::Plain => Carried::Always,
        MultiplexIndicator::Multiplexor => Carried::Multiplexer,
        MultiplexIndicator::MultiplexedSignal(value) => Carried::When(value),
        MultiplexIndicator::MultiplexorAndMultiplexedSignal(_) => {
            return Err(extended(signal));
        }
    };
    // Some tools write SG_MUL_VAL_ for plain multiplexing too: one value, which is that of the signal.
    let plain = |known: &ExtendedMultiplex| match known.mappings.as_slice() {
        [only] => only.min_value == only.max_value && carried == Carried::When(only.min_value),
        _ => false,
    };
    let extends = |known: &&ExtendedMultiplex| {
        known.message_id == message && known.signal_name == signal.name
    };
    if dbc.extended_multiplex.iter().filter(extends).all(plain) {
        Ok(carried)
    } else {
        Err(extended(signal))
    }
}

fn extended(signal: &can_dbc::Signal) -> Refusal {
    Refusal::signal(
        signal,
        format!("`{}` is multiplexed by more than one value or signal", signal.name),
        "extended multiplexing is not supported: describe each frame as a [[message]]",
    )
}

const fn number(value: &NumericValue) -> f64 {
    match value {
        NumericValue::Uint(value) => *value as f64,
        NumericValue::Int(value) => *value as f64,
        NumericValue::Double(value) => *value,
    }
}

const fn float(value: &AttributeValue) -> Option<f64> {
    match value {
        AttributeValue::Uint(value) => Some(*value as f64),
        AttributeValue::Int(value) => Some(*value as f64),
        AttributeValue::Double(value) => Some(*value),
        AttributeValue::String(_) => None,
    }
}

fn not_parsed(file: &str, text: &str, error: &DbcError) -> DescriptionError {
    let (at, what) = match error {
        DbcError::Pest(error) => {
            let start = match error.location {
                pest::error::InputLocation::Pos(start) => start,
                pest::error::InputLocation::Span((start, _)) => start,
            };
            let line = text.get(start..).and_then(|rest| rest.lines().next()).unwrap_or_default();
            (start..start + line.len(), "failed to read as a DBC from here on".to_owned())
        }
        other => (0..0, format!("failed to read as a DBC: {other}")),
    };
    let help =
        "a DBC has its sections in a fixed order: VERSION, NS_, BS_, BU_, BO_, CM_, BA_, VAL_";
    DescriptionError::new(file, text, at, what).with_help(Some(help.to_owned()))
}

/// The first line that `test` holds for, without its end.
fn line_with(text: &str, test: impl Fn(&str) -> bool) -> Option<Range<usize>> {
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let bare = line.trim_end_matches(['\r', '\n']);
        if test(bare) {
            return Some(start..start + bare.len());
        }
        start += line.len();
    }
    None
}
