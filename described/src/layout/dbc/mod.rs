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

use super::message::Message;
use super::signal::Signal;
use super::{Layout, Medium, Note};
use crate::error::FileError;
use crate::hint;
use convert::convert;
use cursor::Unexpected;
use lines::Lines;
use std::collections::BTreeMap;
use syntax::{LONG_NODE, MessageLine, Of, Syntax, Value};

/// The sender that a DBC names for messages without a sending node.
pub const NOBODY: &str = "Vector__XXX";

impl Layout {
    /// The layout of a DBC: `node` is the device, which sends that node's messages and receives the others. Unusable
    /// parts are left out, and [`Layout::notes`] lists them with reasons.
    ///
    /// # Errors
    /// If the text is not a DBC, or has no such node.
    pub fn from_dbc(file: &str, text: &str, node: &str) -> Result<Self, FileError> {
        let syntax = parsed(file, text)?;
        let known: Vec<String> = nodes(&syntax).into_iter().map(|known| known.name).collect();
        if !known.iter().any(|name| name == node) {
            let at = syntax.nodes_at.clone();
            return Err(FileError::new(file, text, at, format!("no node `{node}`"))
                .with_help(Some(hint::proposal(node, &known))));
        }
        let (messages, notes) = convert(file, text, &syntax, &|of| of == node);
        let messages = messages.into_iter().map(|(message, _)| message).collect();
        Ok(Self::new(Medium::Can, messages).noting(notes))
    }

    /// The layout of one or several DBCs, each with its name and text, for a sender of the messages of several nodes,
    /// or of nodes without a name: those that `is_ours` accepts. Identical definitions in two files are one message.
    ///
    /// # Errors
    /// If a text is not a DBC, or if two files define a message or an identifier differently.
    pub fn from_dbcs(
        files: &[(&str, &str)],
        is_ours: &dyn Fn(&str) -> bool,
    ) -> Result<Self, FileError> {
        let mut messages: Vec<Message> = Vec::new();
        let mut origins = Vec::new();
        let (mut by_name, mut by_id) = (BTreeMap::new(), BTreeMap::new());
        let mut notes = Vec::new();
        for (file, text) in files {
            let (read, of_file) = convert(file, text, &parsed(file, text)?, is_ours);
            notes.extend(of_file);
            for (message, at) in read {
                let (name, id) = (message.name.clone(), message.can_id());
                // The first of them.
                let known = by_name.get(&name).into_iter().chain(by_id.get(&id)).min().copied();
                let Some(place) = known else {
                    by_name.insert(name, messages.len());
                    by_id.insert(id, messages.len());
                    messages.push(message);
                    origins.push((file, text, at));
                    continue;
                };
                let Some(what) = difference(&messages[place], &message) else { continue };
                let (other, of_other, at_other) = &origins[place];
                let line = Lines::of(of_other).number(at_other);
                let known = &messages[place].name;
                let message =
                    format!("`{name}` and `{known}` in {other}, line {line}, have {what}");
                let help = "make the two the same, or take one out of a copy of its file";
                return Err(
                    FileError::new(file, text, at, message).with_help(Some(help.to_owned()))
                );
            }
        }
        Ok(Self::new(Medium::Can, messages).noting(notes))
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

/// The nodes that a DBC names, followed by other senders of its messages, including [`NOBODY`] if messages have no
/// other sender.
///
/// # Errors
/// If the text is not a DBC.
pub fn dbc_nodes(file: &str, text: &str) -> Result<Vec<DbcNode>, FileError> {
    Ok(nodes(&parsed(file, text)?))
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
