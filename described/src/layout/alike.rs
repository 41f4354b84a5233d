//! Messages of one sender that look the same.
//!
//! They are refused, unless each answers a request of its own. Bare numbers are such answers (SCPI), and so are registers
//! without their address (Modbus RTU): the request tells what they mean.

use super::message::{Carrier, Message, ToldBy};
use crate::error::{Mistake, Read};
use crate::file::{MessageTable, WhileAnswering};
use crate::place::Place;

/// Compares the last message, that of the last table, with those before it.
pub(super) fn tell_apart(messages: &mut [Message], tables: &[MessageTable]) -> Read {
    let Some((message, before)) = messages.split_last_mut() else { return Ok(()) };
    let last = before.len();
    let place = Place::file().key("message").index(last);
    for (index, other) in before.iter_mut().enumerate() {
        if message.name == other.name {
            let text = format!("two messages have the name `{}`", message.name);
            return Err(Mistake::new(place.key("name"), text));
        }
        let Some(key) = alike(message, other) else { continue };
        let place = place.key(key);
        let alike = if key == "text" { "are alike but for their numbers" } else { "begin alike" };
        let text = format!("`{}` and `{}` {alike}", other.name, message.name);
        let told_by = [index, last].map(|one| told_by(tables, one));
        let [Some(known), Some(new)] = told_by else {
            let or = if key == "can_id" { "" } else { ", or answers a request of its own" };
            return Err(Mistake::new(place, text)
                .help(format!("each message that a side sends has a `{key}` of its own{or}")));
        };
        if known.request == new.request {
            return Err(Mistake::new(place, format!("{text}, and answer the same request"))
                .help(format!("answers to one request have a `{key}` of their own")));
        }
        let waits =
            |one: &ToldBy| tables[one.request].while_answering == Some(WhileAnswering::Queue);
        if let Some(waiting) = [known, new].iter().find(|one| waits(one)) {
            let name = &tables[waiting.request].name;
            return Err(Mistake::new(place, format!("{text}, and `{name}` can wait in a queue"))
                .help("answers that only their requests tell apart are to one request at a time"));
        }
        (other.told_by, message.told_by) = (Some(known), Some(new));
    }
    Ok(())
}

/// The key that makes two messages of one sender look the same.
pub(super) fn alike(message: &Message, other: &Message) -> Option<&'static str> {
    let is_of_one = message.sender == other.sender;
    match (&message.carrier, &other.carrier) {
        (Carrier::Frame { id, .. }, Carrier::Frame { id: known, .. }) => {
            (id == known).then_some("can_id")
        }
        (Carrier::Packet { start, .. }, Carrier::Packet { start: known, .. }) => {
            let prefix = start.starts_with(known) || known.starts_with(start);
            (prefix && is_of_one).then_some("start")
        }
        (Carrier::Line(text), Carrier::Line(known)) => {
            (text.is_like(known) && is_of_one).then_some("text")
        }
        _ => None,
    }
}

/// What tells the message of a table from others that look the same; nothing does for a frame.
fn told_by(tables: &[MessageTable], index: usize) -> Option<ToldBy> {
    let table = tables.get(index).filter(|table| table.can_id.is_none())?;
    let request = table.answers.as_ref()?;
    let request = tables.iter().position(|one| one.name == *request)?;
    Some(ToldBy { request, repeats: table.times.is_some() })
}
