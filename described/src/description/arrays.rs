//! Tables with an index in their name: `[state."cell[1..96]"]` is `cell1` to `cell96` and the array `cell`.

use crate::error::{Mistake, Read};
use crate::expression::{Array, Meaning};
use crate::place::Place;
use std::collections::{BTreeMap, BTreeSet};

/// Maximum number of elements in one array. Assumption: no device here reports more of a kind.
const ELEMENTS_MAX: u32 = 1000;

/// The name of the index in the expressions of an array.
pub(super) const INDEX: &str = "i";

/// A table of the file, or one of several that it expands to.
#[derive(Debug, Clone)]
pub(super) struct Entry<'a, T> {
    pub(super) name: String,
    /// The key in the file.
    pub(super) key: &'a str,
    /// Its index, if its name has one.
    pub(super) index: Option<u32>,
    pub(super) table: &'a T,
}

/// An array and its range of entries.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Family {
    pub(super) name: String,
    /// The index of the first element.
    pub(super) first: u32,
    pub(super) count: u32,
    /// The position of the first element among the entries.
    pub(super) begin: usize,
}

/// The arrays by name.
#[derive(Debug, Clone, Default)]
pub(super) struct Arrays {
    pub(super) parameters: Vec<(String, Array)>,
    pub(super) states: Vec<(String, Array)>,
    /// States at the end of the previous step.
    pub(super) last: Vec<(String, Array)>,
}

impl Arrays {
    /// Arrays of parameters with their first slot; arrays of states with their first slots now and one step before.
    pub(super) fn new(parameters: (&[Family], usize), states: (&[Family], usize, usize)) -> Self {
        let arrays = |families: &[Family], slot: usize| {
            let array = |family: &Family| {
                let slot = u32::try_from(slot + family.begin).unwrap_or(u32::MAX);
                let (count, first) = (family.count, family.first);
                (family.name.clone(), Array { slot, count, first })
            };
            families.iter().map(array).collect()
        };
        Self {
            parameters: arrays(parameters.0, parameters.1),
            states: arrays(states.0, states.1),
            last: arrays(states.0, states.2),
        }
    }

    pub(super) fn of_states(&self) -> impl Iterator<Item = String> {
        self.states.iter().map(|(name, _)| name.clone())
    }

    pub(super) fn names(&self) -> impl Iterator<Item = String> {
        self.parameters.iter().chain(&self.states).map(|(name, _)| name.clone())
    }
}

pub(super) fn find(arrays: &[(String, Array)], name: &str) -> Option<Meaning> {
    let found = arrays.iter().find(|(known, _)| known == name);
    found.map(|(_, array)| Meaning::Array(*array))
}

#[derive(Debug, PartialEq, Eq)]
struct Numbered<'a> {
    before: &'a str,
    first: u32,
    last: u32,
    /// Padded with zeros to this width.
    width: usize,
    behind: &'a str,
}

/// Parses the range in a name; `None` without brackets.
fn numbered(key: &str) -> Result<Option<Numbered<'_>>, &'static str> {
    let Some((before, rest)) = key.split_once('[') else { return Ok(None) };
    let form = "an array is written with its first and its last index: `cell[1..96]`";
    let (range, behind) = rest.split_once(']').ok_or(form)?;
    let (first, last) = range.split_once("..").ok_or(form)?;
    let number = |text: &str| match text.bytes().all(|byte| byte.is_ascii_digit()) {
        true => text.parse::<u32>().map_err(|_| form),
        false => Err(form),
    };
    let width = if first.starts_with('0') { first.len() } else { 0 };
    let (first, last) = (number(first)?, number(last)?);
    if first > last {
        return Err("the first index is the lesser one: `cell[1..96]`");
    }
    if last - first >= ELEMENTS_MAX {
        return Err("an array has at most 1000 elements");
    }
    Ok(Some(Numbered { before, first, last, width, behind }))
}

/// Expands the tables of a section, one for each element of an array, and collects the arrays.
pub(super) fn entries<'a, T>(
    tables: &'a BTreeMap<String, T>,
    section: &str,
) -> Read<(Vec<Entry<'a, T>>, Vec<Family>)> {
    let (mut entries, mut families) = (Vec::new(), Vec::new());
    for (key, table) in tables {
        let place = || Place::file().key(section).key(key).name();
        let found = numbered(key);
        let found = found
            .map_err(|help| Mistake::new(place(), format!("`{key}` is not a name")).help(help))?;
        let Some(Numbered { before, first, last, width, behind }) = found else {
            entries.push(Entry { name: key.clone(), key, index: None, table });
            continue;
        };
        let name = before.to_owned();
        families.push(Family { name, first, count: last - first + 1, begin: entries.len() });
        entries.extend((first..=last).map(|index| Entry {
            name: format!("{before}{index:0width$}{behind}"),
            key,
            index: Some(index),
            table,
        }));
    }
    Ok((entries, families))
}

/// Checks that the names of arrays and elements are unique across all sections.
pub(super) fn distinct<'a>(names: impl Iterator<Item = (&'a str, &'a str, &'a str)>) -> Read {
    let mut known = BTreeSet::new();
    for (section, key, name) in names {
        if !known.insert(name) {
            let place = Place::file().key(section).key(key).name();
            return Err(Mistake::new(place, format!("there is a `{name}` already"))
                .help("parameters, states, machines, tables, arrays and their elements differ in their names"));
        }
    }
    Ok(())
}

/// Checks that nothing has the name of the index in a file with arrays.
pub(super) fn index_is_free<P, S, G>(
    parameters: &BTreeMap<String, P>,
    states: &BTreeMap<String, S>,
    signals: &BTreeMap<String, G>,
) -> Read {
    let mut keys = parameters.keys().chain(states.keys()).chain(signals.keys());
    let Some(array) = keys.find(|key| key.contains('[')) else { return Ok(()) };
    let section = match (parameters.contains_key(INDEX), states.contains_key(INDEX)) {
        (true, _) => "parameter",
        (_, true) => "state",
        _ => return Ok(()),
    };
    let text = format!("`{INDEX}` is the index in the expressions of `{array}`");
    let place = Place::file().key(section).key(INDEX).name();
    Err(Mistake::new(place, text).help("choose another name"))
}

#[cfg(test)]
mod tests {
    use super::{Numbered, numbered};

    #[test]
    fn a_range_may_have_zeros_before_it_and_a_name_behind() {
        let cells = Numbered { before: "Cell", first: 1, last: 96, width: 2, behind: "_U" };
        assert_eq!(numbered("Cell[01..96]_U"), Ok(Some(cells)));
        let one = Numbered { before: "x", first: 3, last: 3, width: 0, behind: "" };
        assert_eq!(numbered("x[3..3]"), Ok(Some(one)));
        assert_eq!(numbered("Status.Temperature"), Ok(None));
        for wrong in ["x[3]", "x[1..", "x[1..a]", "x[2..1]", "x[+1..2]", "x[..3]", "x[1..2000]"] {
            assert!(numbered(wrong).is_err(), "{wrong}");
        }
    }
}
