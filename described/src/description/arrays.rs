//! Tables whose name has an index: `[state."cell[1..96]"]` is `cell1` to `cell96`, and the array `cell`.

use crate::error::Mistake;
use crate::place::Place;
use std::collections::{BTreeMap, BTreeSet};

/// The most elements of one array. Assumption: no device here says more of a kind.
const ELEMENTS_MAX: u32 = 1000;

/// The name of the index in the expressions of an array.
pub(super) const INDEX: &str = "i";

/// A table of the file, or one of the several that it stands for.
#[derive(Debug, Clone)]
pub(super) struct Entry<'a, T> {
    pub(super) name: String,
    /// As it stands in the file.
    pub(super) key: &'a str,
    /// Where its name has one.
    pub(super) index: Option<u32>,
    pub(super) table: &'a T,
}

/// An array: which entries are its elements.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Family {
    pub(super) name: String,
    /// The index of the first one.
    pub(super) first: u32,
    pub(super) count: u32,
    /// The place of the first one among the entries.
    pub(super) begin: usize,
}

/// A name with a range of indices.
#[derive(Debug, PartialEq, Eq)]
struct Numbered<'a> {
    before: &'a str,
    first: u32,
    last: u32,
    /// With zeros up to so many digits.
    width: usize,
    behind: &'a str,
}

/// The range in a name; none where there are no brackets.
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

/// The tables of a section, one for each element of an array, and the arrays.
pub(super) fn entries<'a, T>(
    tables: &'a BTreeMap<String, T>,
    section: &str,
) -> Result<(Vec<Entry<'a, T>>, Vec<Family>), Mistake> {
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

/// Each array and each element has a name of its own, in all of the sections.
pub(super) fn distinct<'a>(
    names: impl Iterator<Item = (&'a str, &'a str, &'a str)>,
) -> Result<(), Mistake> {
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

/// In a file with an array nothing else has the name of the index.
pub(super) fn index_is_free<P, S, G>(
    parameters: &BTreeMap<String, P>,
    states: &BTreeMap<String, S>,
    signals: &BTreeMap<String, G>,
) -> Result<(), Mistake> {
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
