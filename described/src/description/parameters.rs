//! Parameters: numbers that plans set and sweep.

use super::arrays::{Entry, Family};
use crate::error::{Mistake, Read};
use crate::expression::{is_function, is_reserved};
use crate::file::{ParameterTable, StateTable};
use crate::hint;
use crate::layout::spaced;
use crate::place::Place;

/// A number that can be changed while the device runs.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Parameter {
    pub(crate) name: String,
    /// The array that contains it.
    array: Option<String>,
    /// The initial value.
    pub(crate) value: f64,
    pub(crate) unit: String,
    pub(super) minimum: f64,
    pub(super) maximum: f64,
}

impl Parameter {
    fn allows(&self, value: f64) -> Result<(), String> {
        let (least, greatest) = (self.minimum, self.maximum);
        if value.is_finite() && (least..=greatest).contains(&value) {
            return Ok(());
        }
        let unit = spaced(&self.unit);
        let range = match (least.is_finite(), greatest.is_finite()) {
            (false, false) => "it is a finite number".to_owned(),
            (true, false) => format!("it is at least {least}{unit}"),
            (false, true) => format!("it is at most {greatest}{unit}"),
            (true, true) => format!("its range is {least} to {greatest}{unit}"),
        };
        Err(format!("`{}` cannot be {value}{unit}: {range}", self.name))
    }
}

/// The indices of the parameters with this name: one, or all of an array.
pub(super) fn named(parameters: &[Parameter], name: &str) -> Vec<usize> {
    let is_meant = |known: &Parameter| known.name == name || known.array.as_deref() == Some(name);
    let places = parameters.iter().enumerate().filter(|(_, known)| is_meant(known));
    places.map(|(place, _)| place).collect()
}

/// Checks that one of `parameters`, or an array of them, has this name and may have the value; otherwise returns a
/// readable message.
pub(super) fn check(parameters: &[Parameter], name: &str, value: f64) -> Result<(), String> {
    let places = named(parameters, name);
    if places.is_empty() {
        let mut names: Vec<_> = parameters.iter().map(|known| known.name.as_str()).collect();
        names.extend(parameters.iter().filter_map(|known| known.array.as_deref()));
        return Err(format!("no parameter `{name}`: {}", hint::proposal(name, &names)));
    }
    places.into_iter().try_for_each(|place| parameters[place].allows(value))
}

/// Checks that names of variables are words, not reserved, and unique.
pub(super) fn names(
    parameters: &[Entry<'_, ParameterTable>],
    states: &[Entry<'_, StateTable>],
    others: &[(&'static str, &str)],
) -> Read {
    let of_parameters =
        parameters.iter().map(|entry| ("parameter", entry.key, entry.name.as_str()));
    let of_states = states.iter().map(|entry| ("state", entry.key, entry.name.as_str()));
    let of_others = others.iter().map(|(section, name)| (*section, *name, *name));
    for (section, key, name) in of_parameters.chain(of_states).chain(of_others) {
        let place = Place::file().key(section).key(key);
        self::name(name, section, &place)?;
        if section == "state" && parameters.iter().any(|known| known.name == name) {
            return Err(Mistake::new(place.name(), format!("`{name}` is a parameter already")));
        }
    }
    Ok(())
}

/// Checks that the name of a variable is a word, and not reserved.
pub(super) fn name(name: &str, section: &str, place: &Place) -> Read {
    let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    if !name.chars().all(word) || name.chars().next().is_none_or(|c| c.is_ascii_digit()) {
        return Err(Mistake::new(place.name(), format!("`{name}` is not a name"))
            .help("names have letters, digits and `_`, and begin with no digit"));
    }
    if is_reserved(name) || section == "table" && is_function(name) {
        let message = format!("`{name}` has a meaning in every expression");
        return Err(Mistake::new(place.name(), message).help("choose another name"));
    }
    Ok(())
}

pub(super) fn parameters(
    entries: &[Entry<'_, ParameterTable>],
    families: &[Family],
) -> Read<Vec<Parameter>> {
    let array = |place: usize| {
        let has = |family: &&Family| {
            (family.begin..family.begin + family.count as usize).contains(&place)
        };
        families.iter().find(has).map(|family| family.name.clone())
    };
    let parameter = |(place, entry): (usize, &Entry<'_, ParameterTable>)| {
        let table = entry.table;
        let parameter = Parameter {
            name: entry.name.clone(),
            array: array(place),
            value: table.value,
            unit: table.unit.clone(),
            minimum: table.minimum.unwrap_or(f64::NEG_INFINITY),
            maximum: table.maximum.unwrap_or(f64::INFINITY),
        };
        let place = || Place::file().key("parameter").key(entry.key).key("value");
        parameter.allows(table.value).map_err(|message| Mistake::new(place(), message))?;
        Ok(parameter)
    };
    entries.iter().enumerate().map(parameter).collect()
}
