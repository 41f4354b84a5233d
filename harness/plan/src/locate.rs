//! Finds the place of a path in a plan file.

use super::mistake::Segment;
use std::ops::Range;
use toml::de::{DeArray, DeTable, DeValue};

/// The byte range of the value at `path`, or of its nearest existing parent.
pub(super) fn locate(text: &str, path: &[Segment]) -> Range<usize> {
    let Ok(document) = DeTable::parse(text) else {
        return 0..0;
    };
    let mut found = 0..first_line(text);
    let mut table = Some(document.get_ref());
    let mut array: Option<&DeArray<'_>> = None;
    for segment in path {
        if let Segment::Text(within) = segment {
            return part(text, found, within);
        }
        if let (Segment::Entry(name), Some(known)) = (segment, table) {
            let Some((key, value)) = known.get_key_value(name.as_str()) else { break };
            return key.span().start..value.span().end;
        }
        let value = match (segment, table, array) {
            (Segment::Key(key), Some(table), _) => table.get(*key),
            (Segment::Index(index), _, Some(array)) => array.get(*index),
            _ => None,
        };
        let Some(value) = value else { break };
        found = value.span();
        table = value.get_ref().as_table();
        array = match value.get_ref() {
            DeValue::Array(array) => Some(array),
            _ => None,
        };
    }
    found
}

/// The byte range of a part of the string at `found`, which includes the quotes; the whole string if it has
/// escapes or line breaks.
fn part(text: &str, found: Range<usize>, within: &Range<usize>) -> Range<usize> {
    let written = text.get(found.clone()).unwrap_or_default();
    let marks = ["\"\"\"", "'''", "\"", "'"].into_iter().find(|marks| written.starts_with(marks));
    let is_plain = !written.contains('\\') && !written.contains('\n');
    match marks.filter(|_| is_plain) {
        Some(marks) => {
            let start = found.start + marks.len();
            start + within.start..(start + within.end).min(found.end)
        }
        None => found,
    }
}

fn first_line(text: &str) -> usize {
    text.find('\n').unwrap_or(text.len())
}
