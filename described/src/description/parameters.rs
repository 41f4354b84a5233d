//! Parameters: numbers that plans set and sweep.

use crate::error::Mistake;
use crate::expression::is_reserved;
use crate::file::{ParameterTable, StateTable};
use crate::hint;
use crate::place::Place;
use std::collections::BTreeMap;

/// A number that can be changed while the device runs.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Parameter {
    pub(crate) name: String,
    /// Before anybody sets it.
    pub(crate) value: f64,
    pub(crate) unit: String,
    minimum: f64,
    maximum: f64,
}

impl Parameter {
    fn allows(&self, value: f64) -> Result<(), String> {
        let (least, greatest) = (self.minimum, self.maximum);
        if value.is_finite() && (least..=greatest).contains(&value) {
            return Ok(());
        }
        Err(match (least.is_finite(), greatest.is_finite()) {
            (false, false) => format!("`{}` cannot be {value}: it is a finite number", self.name),
            (true, false) => format!("`{}` cannot be {value}: it is at least {least}", self.name),
            (false, true) => format!("`{}` cannot be {value}: it is at most {greatest}", self.name),
            (true, true) => {
                format!("`{}` cannot be {value}: it goes from {least} to {greatest}", self.name)
            }
        })
    }
}

/// Whether one of `parameters` has the name and may have the value; else a message for people.
pub(super) fn check(parameters: &[Parameter], name: &str, value: f64) -> Result<(), String> {
    match parameters.iter().find(|known| known.name == name) {
        Some(known) => known.allows(value),
        None => {
            let names: Vec<_> = parameters.iter().map(|known| known.name.as_str()).collect();
            Err(format!("no parameter `{name}`: {}", hint::proposal(name, &names)))
        }
    }
}

/// The parameters by name.
pub(super) fn parameters(
    tables: &BTreeMap<String, ParameterTable>,
    states: &BTreeMap<String, StateTable>,
) -> Result<Vec<Parameter>, Mistake> {
    for (section, name) in tables
        .keys()
        .map(|name| ("parameter", name))
        .chain(states.keys().map(|name| ("state", name)))
    {
        let place = Place::file().key(section).key(name);
        let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if !name.chars().all(word) || name.chars().next().is_none_or(|c| c.is_ascii_digit()) {
            return Err(Mistake::new(place.name(), format!("`{name}` is not a name"))
                .help("names have letters, digits and `_`, and begin with no digit"));
        }
        if is_reserved(name) {
            return Err(Mistake::new(
                place.name(),
                format!("`{name}` has a meaning in every expression"),
            )
            .help("choose another name"));
        }
        if section == "state" && tables.contains_key(name) {
            return Err(Mistake::new(place.name(), format!("`{name}` is a parameter already")));
        }
    }
    tables
        .iter()
        .map(|(name, table)| {
            let parameter = Parameter {
                name: name.clone(),
                value: table.value,
                unit: table.unit.clone(),
                minimum: table.minimum.unwrap_or(f64::NEG_INFINITY),
                maximum: table.maximum.unwrap_or(f64::INFINITY),
            };
            let place = || Place::file().key("parameter").key(name).key("value");
            parameter.allows(table.value).map_err(|message| Mistake::new(place(), message))?;
            Ok(parameter)
        })
        .collect()
}
