//! Layouts from DBC files.

mod convert;
mod cursor;
mod lines;
mod multiplexing;
mod parts;
mod sending;
mod syntax;
#[cfg(test)]
mod tests;
mod text;

pub use text::dbc_text;

use super::Sender;
use super::message::Message;
use super::signal::Signal;
use super::{Layout, Medium, Note};
use crate::error::FileError;
use crate::hint;
use convert::{Converted, convert};
use cursor::Unexpected;
use lines::Lines;
use parts::{Of, Value};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;
use syntax::{LONG_NODE, MessageLine, Syntax};

/// The sender that a DBC names for messages without a sending node.
pub const NOBODY: &str = "Vector__XXX";

impl Layout {
    /// The layout of a DBC for one of its nodes, as of [`Dbc::layout`].
    ///
    /// # Errors
    /// If the text is not a DBC, or has no such node.
    pub fn from_dbc(file: &str, text: &str, node: &str) -> Result<Self, FileError> {
        Dbc::parse(file, text)?.layout(node)
    }

    /// The layout of one or several DBCs for a sender of the messages of several nodes, or of nodes without a name:
    /// those that `is_ours` accepts. Identical definitions in two files are one message.
    ///
    /// # Errors
    /// If two files define a message or an identifier differently.
    pub fn from_dbcs(dbcs: &[Arc<Dbc>], is_ours: &dyn Fn(&str) -> bool) -> Result<Self, FileError> {
        if let [only] = dbcs {
            return Ok(only.of_senders(is_ours));
        }
        let mut messages: Vec<Message> = Vec::new();
        let mut origins = Vec::new();
        let (mut by_name, mut by_id) = (BTreeMap::new(), BTreeMap::new());
        let mut notes = Vec::new();
        for dbc in dbcs {
            let layout = dbc.of_senders(is_ours);
            notes.extend_from_slice(layout.notes());
            for (message, at) in layout.messages().iter().zip(&dbc.places) {
                let (name, id) = (message.name.clone(), message.can_id());
                // The first of them.
                let known = by_name.get(&name).into_iter().chain(by_id.get(&id)).min().copied();
                let Some(place) = known else {
                    by_name.insert(name, messages.len());
                    by_id.insert(id, messages.len());
                    messages.push(message.clone());
                    origins.push((dbc, at));
                    continue;
                };
                let Some(what) = difference(&messages[place], message) else { continue };
                let (other, at_other) = origins[place];
                let line = Lines::of(&other.text).number(at_other);
                let known = &messages[place].name;
                let message =
                    format!("`{name}` and `{known}` in {}, line {line}, have {what}", other.file);
                let help = "make the two the same, or take one out of a copy of its file";
                return Err(FileError::new(&dbc.file, &dbc.text, at.clone(), message)
                    .with_help(Some(help.to_owned())));
            }
        }
        Ok(Self::new(Medium::Can, messages).noting(notes))
    }
}

/// A DBC that has been read: it gives a layout for each of its nodes.
#[derive(Debug, Clone)]
pub struct Dbc {
    file: String,
    text: String,
    nodes: Vec<DbcNode>,
    /// Where its nodes are listed.
    nodes_at: Range<usize>,
    /// Its messages as a receiver of all of them sees them.
    layout: Layout,
    /// For each message the nodes that send it, and its place in the text.
    senders: Vec<Vec<String>>,
    places: Vec<Range<usize>>,
}

impl Dbc {
    /// Reads a DBC; `file` names it in messages. Unusable parts are left out, and [`Layout::notes`] lists them with
    /// reasons.
    ///
    /// # Errors
    /// If the text is not a DBC.
    pub fn parse(file: &str, text: &str) -> Result<Self, FileError> {
        let syntax = parsed(file, text)?;
        let (read, notes) = convert(file, text, &syntax);
        let (mut messages, mut senders, mut places) = (Vec::new(), Vec::new(), Vec::new());
        for Converted { message, sent_by, at } in read {
            messages.push(message);
            senders.push(sent_by);
            places.push(at);
        }
        Ok(Self {
            file: file.to_owned(),
            text: text.to_owned(),
            nodes: nodes(&syntax),
            nodes_at: syntax.nodes_at,
            layout: Layout::new(Medium::Can, messages).noting(notes),
            senders,
            places,
        })
    }

    /// Its name in messages.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// The nodes that it names, followed by other senders of its messages, including [`NOBODY`] if messages have no
    /// other sender.
    pub fn nodes(&self) -> &[DbcNode] {
        &self.nodes
    }

    /// The layout for a device that is this node: it sends the node's messages and receives the others.
    ///
    /// # Errors
    /// If there is no such node.
    pub fn layout(&self, node: &str) -> Result<Layout, FileError> {
        if self.nodes.iter().any(|known| known.name == node) {
            return Ok(self.of_senders(&|of| of == node));
        }
        let known: Vec<&str> = self.nodes.iter().map(|known| known.name.as_str()).collect();
        let help = match known.is_empty() {
            true => "the DBC names no node and has no message".to_owned(),
            false => hint::proposal(node, &known),
        };
        let message = format!("no node `{node}`");
        Err(FileError::new(&self.file, &self.text, self.nodes_at.clone(), message)
            .with_help(Some(help)))
    }

    /// The layout for a device that sends what the nodes that `is_ours` accepts send.
    fn of_senders(&self, is_ours: &dyn Fn(&str) -> bool) -> Layout {
        let mut messages = self.layout.messages.to_vec();
        for (message, senders) in messages.iter_mut().zip(&self.senders) {
            if senders.iter().any(|sender| is_ours(sender)) {
                message.sender = Sender::Device;
            }
        }
        Layout { messages: messages.into(), ..self.layout.clone() }
    }
}

/// DBCs that have been read, so that none is read twice: a rig may name one for each of its nodes.
#[derive(Debug, Default)]
pub struct Dbcs(BTreeMap<String, Arc<Dbc>>);

impl Dbcs {
    /// The DBC with this name and text.
    ///
    /// # Errors
    /// As [`Dbc::parse`].
    pub fn get(&mut self, file: &str, text: &str) -> Result<Arc<Dbc>, FileError> {
        if let Some(known) = self.0.get(file).filter(|known| known.text == text) {
            return Ok(Arc::clone(known));
        }
        let dbc = Arc::new(Dbc::parse(file, text)?);
        self.0.insert(file.to_owned(), Arc::clone(&dbc));
        Ok(dbc)
    }
}

/// A node of a DBC.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DbcNode {
    /// Its name.
    pub name: String,
    /// Number of messages that it sends.
    pub messages: usize,
}

fn nodes(syntax: &Syntax) -> Vec<DbcNode> {
    let mut nodes: Vec<DbcNode> = Vec::new();
    let mut add = |name: &str, messages: usize| {
        let name = long_node(syntax, name);
        match nodes.iter_mut().find(|known| known.name == name) {
            Some(known) => known.messages += messages,
            None => nodes.push(DbcNode { name: name.to_owned(), messages }),
        }
    };
    syntax.nodes.iter().for_each(|name| add(name, 0));
    for message in syntax.messages.iter().filter(|message| message.name != ORPHANS) {
        senders(syntax, message).for_each(|name| add(name, 1));
    }
    nodes
}

/// The nodes that send a message, as written in the file.
fn senders<'a>(syntax: &'a Syntax, message: &'a MessageLine) -> impl Iterator<Item = &'a str> {
    let first = if message.sender.is_empty() { NOBODY } else { message.sender.as_str() };
    let also = syntax.senders.get(&message.id).into_iter().flatten().map(String::as_str);
    // Additional senders may repeat the first one, and they replace `NOBODY`.
    let also = also.filter(move |name| *name != first);
    let is_sent = also.clone().next().is_some();
    let first = Some(first).filter(|first| *first != NOBODY || !is_sent);
    first.into_iter().chain(also)
}

/// Holds signals that belong to no message; Vector's tools write it.
const ORPHANS: &str = "VECTOR__INDEPENDENT_SIG_MSG";

/// The node's name, longer than 32 letters if an attribute specifies so.
fn long_node<'a>(syntax: &'a Syntax, name: &'a str) -> &'a str {
    let long = syntax.attribute(Of::Node(name.to_owned()), LONG_NODE);
    long.and_then(Value::text).unwrap_or(name)
}

fn parsed(file: &str, text: &str) -> Result<Syntax, FileError> {
    Syntax::parse(text).map_err(|Unexpected { at, expected }| {
        // Some locales write `0,5`, which reads as one number too many.
        let is_comma = text.get(at.clone()) == Some(",") && expected.starts_with("`)`");
        let help = is_comma.then(|| "numbers have a decimal point: `0.5`".to_owned());
        let message = format!("failed to read the DBC: expected {expected}");
        FileError::new(file, text, at, message).with_help(help)
    })
}

/// The difference between two definitions of a message, apart from comments.
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
        (one.send != other.send, "one identifier and two ways to be sent"),
    ];
    let what = apart.iter().find(|(differs, _)| *differs).map(|(_, what)| (*what).to_owned());
    what.or_else(|| {
        let ours = one.signals.iter().find(|signal| lacks(other, signal));
        let signal = ours.or_else(|| other.signals.iter().find(|signal| lacks(one, signal)))?;
        Some(format!("one identifier and two definitions of `{}`", signal.name))
    })
}
