//! What a description says of a device.

use crate::error::{DescriptionError, Mistake};
use crate::file::{File, MessageRules, MessageTable};
use crate::hint;
use crate::layout::Layout;
use crate::place::Place;
use std::collections::BTreeMap;
use toml::de::DeTable;

/// A device as its user describes it, checked.
#[derive(Debug, Clone)]
pub struct Description {
    /// Its name, which its random numbers belong to.
    pub name: String,
    /// What it is, in a line.
    pub title: String,
    /// Where its numbers come from.
    pub source: String,
    layout: Layout,
    parameters: Vec<Parameter>,
}

/// A number that can be changed while the device runs.
#[derive(Debug, Clone, PartialEq)]
struct Parameter {
    name: String,
    value: f64,
    unit: String,
    minimum: f64,
    maximum: f64,
}

impl Description {
    /// Reads a description. `file` is its name in messages; `read` hands over the files that it names (a
    /// DBC, CSV) by the name in the description, or says why it cannot.
    ///
    /// # Errors
    /// With the place of the first mistake, in the description or in a file that it names.
    pub fn parse(
        file: &str,
        text: &str,
        read: &mut dyn FnMut(&str) -> Result<String, String>,
    ) -> Result<Self, DescriptionError> {
        let (said, messages) = split(file, text)?;
        let layout = layout(file, text, &said, messages.as_deref(), read)?;
        let parameters = said.parameter.iter().map(|(name, table)| Parameter {
            name: name.clone(),
            value: table.value,
            unit: table.unit.clone(),
            minimum: table.minimum.unwrap_or(f64::NEG_INFINITY),
            maximum: table.maximum.unwrap_or(f64::INFINITY),
        });
        let parameters = parameters.collect();
        Ok(Self { name: said.name, title: said.title, source: said.source, layout, parameters })
    }

    /// Its messages and their signals.
    pub const fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Its parameters: name, value and unit, by name.
    pub fn parameters(&self) -> impl Iterator<Item = (&str, f64, &str)> {
        self.parameters.iter().map(|known| (known.name.as_str(), known.value, known.unit.as_str()))
    }

    /// Whether the parameter exists and may have this value.
    ///
    /// # Errors
    /// With a message for people: the nearest name, or the range.
    pub fn check_parameter(&self, name: &str, value: f64) -> Result<(), String> {
        let Some(known) = self.parameters.iter().find(|known| known.name == name) else {
            let names: Vec<_> = self.parameters.iter().map(|known| known.name.as_str()).collect();
            return Err(format!("no parameter `{name}`: {}", hint::proposal(name, &names)));
        };
        if value.is_finite() && (known.minimum..=known.maximum).contains(&value) {
            return Ok(());
        }
        let (least, greatest) = (known.minimum, known.maximum);
        Err(format!("`{name}` cannot be {value}: it goes from {least} to {greatest}"))
    }
}

/// The file with rules for its messages, and the tables that say all of them where it has any.
type Split = (File<BTreeMap<String, MessageRules>>, Option<Vec<MessageTable>>);

fn split(file: &str, text: &str) -> Result<Split, DescriptionError> {
    let wrong = |error: &toml::de::Error| DescriptionError::from_toml(file, text, error);
    let document = DeTable::parse(text).map_err(|error| wrong(&error))?;
    let tables = document.get_ref().get("message").is_some_and(|value| value.get_ref().is_array());
    if !tables {
        return Ok((toml::from_str(text).map_err(|error| wrong(&error))?, None));
    }
    let whole: File<Vec<MessageTable>> = toml::from_str(text).map_err(|error| wrong(&error))?;
    let rules = whole.message.iter().map(|table| (table.name.clone(), table.rules())).collect();
    let said = File {
        name: whole.name,
        title: whole.title,
        source: whole.source,
        dbc: whole.dbc,
        node: whole.node,
        step_s: whole.step_s,
        serial: whole.serial,
        parameter: whole.parameter,
        state: whole.state,
        signal: whole.signal,
        message: rules,
    };
    Ok((said, Some(whole.message)))
}

fn layout<M>(
    file: &str,
    text: &str,
    said: &File<M>,
    tables: Option<&[MessageTable]>,
    read: &mut dyn FnMut(&str) -> Result<String, String>,
) -> Result<Layout, DescriptionError> {
    let mistake = |key: &str, message: &str, help: &str| {
        Err(Mistake::new(Place::file().key(key), message).help(help).located(file, text))
    };
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
    let found = read(dbc).map_err(|error| {
        let message = format!("failed to read `{dbc}`: {error}");
        Mistake::new(Place::file().key("dbc"), message).located(file, text)
    })?;
    Layout::from_dbc(dbc, &found, node)
}
