//! What parts the cells of a table, and the decimal sign of their numbers.

use super::descriptor::{Dialect, Resource};
use std::collections::BTreeSet;

/// Delimiters that programs write.
const DELIMITERS: [char; 4] = [';', '\t', '|', ','];

/// The delimiter of a table.
pub(super) fn delimiter(written: Option<&Dialect>) -> Result<u8, &'static str> {
    match written.and_then(|dialect| dialect.delimiter.as_deref()) {
        None => Ok(b','),
        Some(text) => match text.as_bytes() {
            [one] if one.is_ascii() && !one.is_ascii_alphanumeric() && *one != b'"' => Ok(*one),
            _ => Err("expected one character as the delimiter of a dialect"),
        },
    }
}

/// The names of the fields whose numbers have a decimal comma: as the field says, else its table.
pub(super) fn commas(resource: &Resource) -> Result<BTreeSet<String>, &'static str> {
    let of_table = resource.dialect.as_ref().and_then(|dialect| dialect.decimal.as_deref());
    let mut commas = BTreeSet::new();
    for field in resource.schema.iter().flat_map(|schema| &schema.fields) {
        match field.decimal.as_deref().or(of_table) {
            None | Some(".") => {}
            Some(",") => {
                commas.insert(field.name.clone());
            }
            Some(_) => return Err("expected `.` or `,` as the decimalChar"),
        }
    }
    Ok(commas)
}

/// The delimiter that a header seems to have instead of `used`, by which none of its names is known.
pub(super) fn other(names: &[&str], known: impl Fn(&str) -> bool, used: u8) -> Option<char> {
    if names.iter().any(|name| known(name)) {
        return None;
    }
    let used = char::from(used);
    let whole = names.join(&used.to_string());
    let is_apart = |by: char| {
        let mut parts = whole.split(by).map(|part| part.trim().trim_matches('"'));
        whole.contains(by) && (names.len() == 1 || parts.any(&known))
    };
    DELIMITERS.into_iter().filter(|by| *by != used).find(|by| is_apart(*by))
}
