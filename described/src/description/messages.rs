//! When messages are sent, and the values of received messages until one arrives.

use super::answers::{self, Answer, WhileAnswering};
use super::arrays;
use super::parts::{PERIOD_S_MIN, seconds};
use super::scope::Local;
use super::sending;
use super::source::{SignalSource, Source, source};
use super::variables::Variables;
use crate::error::{Mistake, Read};
use crate::expression::{Batch, Expression};
use crate::file::{MessageRules, SourceTable};
use crate::files::Files;
use crate::hint;
use crate::layout::{EncodeError, Layout, Message, Selection, SendKind, SendRule, Sender, Signal};
use crate::place::{Place, given};
use std::collections::BTreeMap;
use std::ops::Range;
use wire::time::Span;

#[derive(Debug, Clone)]
pub(crate) struct Sent {
    /// Its index in the layout.
    pub(crate) message: usize,
    pub(crate) period: Option<Span>,
    /// Other reasons to send it.
    pub(crate) send: SendRule,
    pub(crate) answers: Option<Answer>,
    /// One per signal.
    pub(crate) signals: Vec<SignalSource>,
    /// The positions of its signals among those of all sent messages.
    pub(crate) places: Range<usize>,
    /// The blocks of [`Model::expressions`](super::Model::expressions) with its signals.
    pub(crate) blocks: Box<[usize]>,
    /// The positions among its signals of those that are no expressions.
    pub(crate) others: Box<[usize]>,
    /// The numbers that an undriven multiplexer cycles through: per signal, empty for others.
    pub(crate) pages: Vec<Vec<u64>>,
}

impl Sent {
    /// Its messages that have expressions of the same occasion are sent at the same times.
    fn occasion(&self) -> Result<Span, usize> {
        let is_alone = self.answers.is_some() || self.send.kind != SendKind::Cyclic;
        self.period.filter(|_| !is_alone).ok_or(self.message)
    }

    /// Its expressions, each with its occasion and its position among the signals of all sent messages.
    fn expressions(&self) -> impl Iterator<Item = (Result<Span, usize>, usize, &Expression)> {
        self.places.clone().zip(&self.signals).filter_map(|(place, signal)| match &signal.source {
            Source::Expression(expression) => Some((self.occasion(), place, expression)),
            _ => None,
        })
    }
}

/// The expressions of all sent messages.
pub(super) fn expressions(sent: &mut [Sent]) -> Batch {
    let mut end = 0;
    for one in &mut *sent {
        one.places = end..end + one.signals.len();
        end = one.places.end;
        let is_other = |place: &usize| !matches!(one.signals[*place].source, Source::Expression(_));
        one.others = (0..one.signals.len()).filter(is_other).collect();
    }
    let batch = Batch::new(sent.iter().flat_map(Sent::expressions));
    for one in sent {
        one.blocks = batch.blocks_of(&one.places);
    }
    batch
}

#[derive(Debug, Clone)]
pub(crate) struct Heard {
    /// Its index in the layout.
    pub(crate) message: usize,
    /// After this time without the message its signals return to their initial values.
    pub(crate) timeout: Option<Span>,
    /// Handling of the message while another is being answered; `None` means that it is always used.
    pub(crate) while_answering: Option<WhileAnswering>,
}

/// The place of a message in the file: a table of its name, or an entry of a list.
pub(super) fn place(index: usize, message: &Message, listed: bool) -> Place {
    let all = Place::file().key("message");
    if listed { all.index(index) } else { all.key(&message.name) }
}

/// The layout with the periods and initial values of the file.
pub(super) fn ruled(
    layout: Layout,
    rules: &BTreeMap<String, MessageRules>,
    listed: bool,
) -> Read<Layout> {
    let names: Vec<String> = layout.messages().iter().map(|known| known.name.clone()).collect();
    if let Some(name) = rules.keys().find(|name| !names.contains(name)) {
        let place = Place::file().key("message").key(name);
        let message = format!("no message `{name}`");
        let help = layout.left_out(name).map(ToString::to_string);
        let help = help.unwrap_or_else(|| hint::proposal(name, &names));
        return Err(Mistake::new(place.name(), message).help(help));
    }
    for (index, message) in layout.messages().iter().enumerate() {
        if let Some(rules) = rules.get(&message.name) {
            let place = place(index, message, listed);
            layout.lacks(&message.name, &rules.protection(), &place)?;
        }
    }
    layout.changed(|index, message| {
        let Some(rules) = rules.get(&message.name) else { return Ok(()) };
        let place = place(index, message, listed);
        sending::ruled(message, rules, &place)?;
        start(message, rules, &place)?;
        message.protect(&rules.protection(), &place)
    })
}

fn start(message: &mut Message, rules: &MessageRules, place: &Place) -> Read {
    for (name, value) in &rules.initial {
        let place = place.key("initial").key(name);
        if message.sender == Sender::Device {
            let text = format!("`{}` is sent by the device", message.name);
            return Err(
                Mistake::new(place.name(), text).help("its signals have a source: [signal.NAME]")
            );
        }
        let names: Vec<String> = message.signals.iter().map(|known| known.name.clone()).collect();
        let Some(signal) = message.signals.iter_mut().find(|known| known.name == *name) else {
            let text = format!("`{}` has no signal `{name}`", message.name);
            return Err(Mistake::new(place.name(), text).help(hint::proposal(name, &names)));
        };
        let value =
            signal.value_of(value).map_err(|(text, help)| place.mistake(text).help(help))?;
        if !(signal.minimum..=signal.maximum).contains(&value) {
            let Signal { minimum, maximum, ref unit, .. } = *signal;
            let (signal, unit) = (name.clone(), unit.clone());
            let error = EncodeError::OutOfRange { signal, value, minimum, maximum, unit };
            return Err(Mistake::new(place, error.to_string()));
        }
        signal.start = value;
    }
    Ok(())
}

pub(super) fn messages(
    rules: &BTreeMap<String, MessageRules>,
    sources: &BTreeMap<String, SourceTable>,
    layout: &Layout,
    variables: &Variables,
    listed: bool,
    files: &mut dyn Files,
) -> Read<(Vec<Sent>, Vec<Heard>)> {
    let unruled = MessageRules::default();
    let (mut sent, mut heard) = (Vec::new(), Vec::new());
    for (index, message) in layout.messages().iter().enumerate() {
        let rules = rules.get(&message.name).unwrap_or(&unruled);
        let place = place(index, message, listed);
        match message.sender {
            Sender::Device => sent.push(send(index, message, rules, variables, &place)?),
            Sender::Host => heard.push(hear(index, message, rules, &place)?),
        }
    }
    let at = |message: usize| place(message, &layout.messages()[message], listed);
    agree(layout.messages(), (&sent, &at), &heard)?;
    let (sources, _) = arrays::entries(sources, "signal")?;
    for entry in &sources {
        let (name, table) = (&entry.name, entry.table);
        let place = Place::file().key("signal").key(entry.key);
        let (message, signal) = layout
            .resolve_among(name, Some(Sender::Device))
            .map_err(|error| unsent(name, layout, &error, &place))?;
        let known = &layout.messages()[message].name;
        let Some(sent) = sent.iter_mut().find(|sent| sent.message == message) else { continue };
        if sent.period.is_none() && sent.answers.is_none() && sent.send.is_cyclic() {
            let text = format!("`{name}` is in `{known}`, which is never sent");
            return Err(Mistake::new(place, text)
                .help(format!("give `{known}` a `period_s`, or say which message it `answers`")));
        }
        if !matches!(sent.signals[signal].source, Source::Unsaid) {
            let text = format!(
                "`{known}.{}` has two sources",
                layout.messages()[message].signals[signal].name
            );
            return Err(Mistake::new(place, text));
        }
        let unit = &layout.messages()[message].signals[signal].unit;
        let has_parts = sent.answers.as_ref().is_some_and(|answer| answer.times.is_some());
        let scope = Local { scope: variables, index: entry.index, has_parts };
        sent.signals[signal] = source(table, unit, &scope, &place, files)?;
    }
    for entry in &sources {
        let name = &entry.name;
        let Ok((message, signal)) = layout.resolve_among(name, Some(Sender::Device)) else {
            continue;
        };
        let of_message = sent.iter().find(|sent| sent.message == message);
        let Some((selection, value)) =
            of_message.and_then(|sent| never(&layout.messages()[message], sent, signal))
        else {
            continue;
        };
        let multiplexer = &layout.messages()[message].signals[selection.multiplexer].name;
        let text = format!(
            "`{name}` is never sent: it is in frames whose `{multiplexer}` is {selection}, and that is always {value}"
        );
        return Err(Mistake::new(Place::file().key("signal").key(entry.key).name(), text)
            .help(format!("without [signal.{multiplexer}] it takes all its numbers in turn")));
    }
    Ok((sent, heard))
}

/// Checks that `while_answering` has an answer to it, and that a `busy` answer has something to refuse.
fn agree(
    messages: &[Message],
    (sent, places): (&[Sent], &dyn Fn(usize) -> Place),
    heard: &[Heard],
) -> Read {
    let answers = |busy: bool, question: usize| {
        let answers = sent.iter().filter_map(|sent| sent.answers.as_ref());
        answers.into_iter().any(|answer| answer.busy == busy && answer.question == question)
    };
    for heard in heard.iter().filter(|heard| heard.while_answering.is_some()) {
        if !answers(false, heard.message) {
            let text = format!("nothing answers `{}`", messages[heard.message].name);
            return Err(Mistake::new(places(heard.message).key("while_answering").name(), text)
                .help("add `answers` to the message that does"));
        }
    }
    for sent in sent {
        let Some(answer) = sent.answers.as_ref().filter(|answer| answer.busy) else { continue };
        let question = heard.iter().find(|heard| heard.message == answer.question);
        if question.is_none_or(|heard| heard.while_answering.is_none()) {
            let text = format!("`{}` is never refused", messages[answer.question].name);
            return Err(Mistake::new(places(sent.message).key("busy").name(), text)
                .help("add `while_answering` to it: \"refuse\" or \"queue\""));
        }
    }
    Ok(())
}

/// For a signal that is never sent because its multiplexer is a different constant: the required selection, and that
/// constant.
fn never<'a>(message: &'a Message, sent: &Sent, signal: usize) -> Option<(&'a Selection, f64)> {
    message.selections(signal).find_map(|selection| {
        let source = &sent.signals[selection.multiplexer].source;
        let Source::Expression(expression) = source else { return None };
        let value = expression.known()?;
        let number = message.signals[selection.multiplexer].number_of(value)?;
        (!selection.has(number)).then_some((selection, value))
    })
}

fn unsent(name: &str, layout: &Layout, error: &crate::SignalName, place: &Place) -> Mistake {
    if layout.resolve_among(name, Some(Sender::Host)).is_ok() {
        return Mistake::new(place.name(), format!("`{name}` is sent by the host"))
            .help("the device hears it; what it is before that is `initial` of its message");
    }
    let advice = match error {
        crate::SignalName::Ambiguous { help, .. } => {
            format!("{help}; a key with a dot has quotes: [signal.\"Message.{name}\"]")
        }
        crate::SignalName::Unknown { help, .. } => help.clone(),
    };
    Mistake::new(place.name(), error.to_string()).help(advice)
}

fn send(
    index: usize,
    message: &Message,
    rules: &MessageRules,
    variables: &Variables,
    place: &Place,
) -> Read<Sent> {
    if rules.timeout_s.is_some() {
        let text = format!("`{}` is sent by the device", message.name);
        return Err(Mistake::new(place.key("timeout_s").name(), text)
            .help("a `timeout_s` is of a message that it hears"));
    }
    if let Some(key) = given!(rules; while_answering, queue) {
        let text = format!("`{}` is sent by the device", message.name);
        return Err(Mistake::new(place.key(key).name(), text)
            .help(format!("`{key}` is of a message that it hears")));
    }
    let answers = answers::answer(rules, variables, place)?;
    let unsaid = || SignalSource { source: Source::Unsaid, noise: 0.0 };
    let pages =
        (0..message.signals.len()).map(|signal| message.pages(signal).into_iter().collect());
    Ok(Sent {
        message: index,
        period: message.period,
        send: message.send.clone(),
        answers,
        signals: message.signals.iter().map(|_| unsaid()).collect(),
        places: 0..0,
        blocks: Box::default(),
        others: Box::default(),
        pages: pages.collect(),
    })
}

fn hear(index: usize, message: &Message, rules: &MessageRules, place: &Place) -> Read<Heard> {
    if let Some(key) = given!(rules; answers, delay_s, when, times, every_s, busy) {
        let text = format!("`{}` is sent by the host", message.name);
        return Err(Mistake::new(place.key(key).name(), text)
            .help(format!("`{key}` is of a message that the device sends")));
    }
    let timeout = rules.timeout_s.map(|s| seconds(s, PERIOD_S_MIN, &place.key("timeout_s")));
    let while_answering = answers::while_answering(rules, place)?;
    Ok(Heard { message: index, timeout: timeout.transpose()?, while_answering })
}
