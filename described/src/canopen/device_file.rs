//! What a device file says beside its EDS.

use super::dictionary::{Dictionary, Entry};
use super::{eds, layout as messages};
use crate::error::{FileError, Mistake, Read};
use crate::file::{File, Formula, StateTable};
use crate::files::Files;
use crate::hint;
use crate::layout::{Layout, Scale, Sender};
use crate::place::{Place, given};
use std::sync::Arc;

/// Reads the layout of a description with an `eds`.
pub(crate) fn layout(
    (file, text): (&str, &str),
    said: &File,
    name: &str,
    files: &mut dyn Files,
) -> Result<Layout, FileError> {
    let located = |mistake: Mistake| mistake.located(file, text);
    let place = Place::file();
    let listed = said.message.tables().map(|_| "message");
    let help = "the messages of a CANopen device are those of its `eds`";
    if let Some(key) = given!(said; dbc, node, serial).or(listed) {
        let message = format!("`{key}` beside `eds`");
        return Err(located(Mistake::new(place.key(key).name(), message).help(help)));
    }
    if let Some(name) = said.signal.keys().next() {
        let message = "a CANopen device has objects, and its PDOs show them";
        let help = "write [object.NAME] with the `expression`";
        return Err(located(place.key("signal").key(name).name().mistake(message).help(help)));
    }
    let eds = files.text(name).map_err(|error| {
        located(Mistake::new(place.key("eds"), format!("failed to read `{name}`: {error}")))
    })?;
    let node_id = match said.node_id {
        Some(id) => id,
        None => eds::commissioned(&eds).map(i64::from).ok_or_else(|| {
            let help = "node_id = 5: from 1 to 127; the file itself says none";
            let message = "the device has no `node_id`";
            located(Mistake::new(place.key("eds").name(), message).help(help))
        })?,
    };
    let node_id =
        u8::try_from(node_id).ok().filter(|id| (1..=127).contains(id)).ok_or_else(|| {
            let message = format!("{node_id} is no node identifier");
            located(Mistake::new(place.key("node_id"), message).help("from 1 to 127"))
        })?;
    let mut dictionary = eds::dictionary(name, &eds, node_id)?;
    for (object, table) in &said.object {
        let at = place.key("object").key(object);
        let entry = find(&mut dictionary, object, &at).map_err(located)?;
        entry.unit.clone_from(&table.unit);
        let factor = table.scale.unwrap_or(1.0);
        entry.scale = Scale::new(factor, 0.0)
            .ok_or_else(|| located(at.key("scale").mistake(format!("{factor} is no scale"))))?;
    }
    let dictionary = Arc::new(dictionary);
    let layout = messages::layout(&dictionary).map_err(|(index, sub, why)| {
        let at = dictionary.find(index, sub).or_else(|_| dictionary.find(index, 0));
        let at = at.map_or(0..0, |entry| entry.at.clone());
        let message = format!("[{index:04X}sub{sub:X}] {why}");
        FileError::new(name, &eds, at, message)
    })?;
    let is_sent = |name: &String| {
        let mut sent = layout.messages().iter().filter(|message| message.sender == Sender::Device);
        sent.any(|message| message.name == *name)
    };
    if let Some(name) = said.message.rules().into_keys().find(is_sent) {
        let at = place.key("message").key(&name).name();
        let message = "a CANopen device sends its messages as its objects say";
        let help = "when it sends a PDO is in the objects from 1800h on of its `eds`";
        return Err(located(Mistake::new(at, message).help(help)));
    }
    Ok(layout)
}

/// Refuses the keys of a CANopen device in a file without an EDS.
pub(crate) fn unused(said: &File) -> Read {
    let keys = [
        ("node_id", said.node_id.is_some()),
        ("object", !said.object.is_empty()),
        ("emergency", !said.emergency.is_empty()),
    ];
    let Some((key, _)) = keys.iter().find(|(_, given)| *given) else { return Ok(()) };
    let message = format!("`{key}` is of a CANopen device");
    Err(Mistake::new(Place::file().key(key).name(), message).help("name its `eds`"))
}

fn find<'a>(dictionary: &'a mut Dictionary, name: &str, at: &Place) -> Read<&'a mut Entry> {
    let Some(place) = dictionary.named(name) else {
        let known: Vec<&str> = dictionary.application().map(|(_, one)| one.name()).collect();
        let message = format!("the EDS has no object `{name}`");
        return Err(Mistake::new(at.name(), message).help(hint::proposal(name, &known)));
    };
    Ok(&mut dictionary.entries[place])
}

/// Adds a state for each object of the application that no expression computes: masters write it, and machines may.
/// Returns the names of the added ones.
pub(crate) fn held(said: &mut File, dictionary: &Dictionary) -> Read<Vec<String>> {
    let mut names = Vec::new();
    for (_, entry) in dictionary.application() {
        let name = entry.name();
        if let Some(section) = said.section_of(name) {
            let message = format!("`{name}` is an object of the EDS");
            let help = "give it another name, and the object its value by [object.NAME]";
            let at = Place::file().key(section).key(name).name();
            return Err(Mistake::new(at, message).help(help));
        }
        if said.object.get(name).is_some_and(|table| table.is_computed()) {
            continue;
        }
        let start = entry.value(&entry.start).unwrap_or(0.0);
        let state = StateTable {
            start: Some(Formula::Number(start)),
            rate: None,
            value: None,
            unit: entry.unit.clone(),
            doc: entry.title.clone(),
        };
        said.state.insert(name.to_owned(), state);
        names.push(name.to_owned());
    }
    Ok(names)
}
