//! The content of a description, and the layout that it names or contains.

use super::parts;
use crate::canopen;
use crate::error::{FileError, Mistake};
use crate::file::File;
use crate::files::Files;
use crate::layout::Layout;
use crate::place::Place;

/// Reads the file in whichever of the two forms it has.
pub(super) fn said(file: &str, text: &str) -> Result<File, FileError> {
    text.parse().map_err(|error| FileError::from_toml(file, text, &error))
}

/// The layout from the file or its DBC.
pub(super) fn layout(
    file: &str,
    text: &str,
    said: &File,
    files: &mut dyn Files,
) -> Result<Layout, FileError> {
    if let Some(eds) = &said.eds {
        return canopen::layout((file, text), said, eds, files);
    }
    canopen::unused(said).map_err(|mistake| mistake.located(file, text))?;
    let mistake = |key: &str, message: &str, help: &str| {
        Err(Mistake::new(Place::file().key(key), message).help(help).located(file, text))
    };
    let tables = said.message.tables();
    let Some(dbc) = &said.dbc else {
        let Some(tables) = tables else {
            return mistake(
                "",
                "the file has no messages",
                "name a `dbc`, or add [[message]] tables",
            );
        };
        if said.node.is_some() {
            return mistake(
                "node",
                "`node` is one of a `dbc`",
                "say `sent_by` in each [[message]]",
            );
        }
        return Layout::from_tables(said.serial, tables).map_err(|error| error.located(file, text));
    };
    if tables.is_some() {
        let help = "with a `dbc`, [message.NAME] says what it does not";
        return mistake("message", "the messages are in the `dbc` already", help);
    }
    if said.serial.is_some() {
        return mistake("serial", "a `dbc` describes messages on CAN", "leave out one of the two");
    }
    let Some(node) = &said.node else {
        let help = "node = \"...\": who of the DBC's nodes the device is";
        return mistake("dbc", "the file does not say which `node` it is", help);
    };
    let found = parts::text(files, dbc, &Place::file().key("dbc"));
    let found = found.map_err(|mistake| mistake.located(file, text))?;
    let read = files.dbc(dbc, &found)?;
    read.layout(node).map_err(|error| {
        // Which node it is, this file says.
        let message = format!("{} in `{dbc}`", error.message());
        let help = error.advice().unwrap_or_default();
        Mistake::new(Place::file().key("node"), message).help(help).located(file, text)
    })
}
