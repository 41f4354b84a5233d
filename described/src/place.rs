//! Converts a path in a TOML file to a position in its text.

use std::ops::Range;
use toml::de::{DeTable, DeValue};

/// One step into a TOML value.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Segment {
    Key(String),
    Index(usize),
}

/// A place in a TOML file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Place {
    path: Vec<Segment>,
    mark: Mark,
}

/// The marked part of the value at a path.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
enum Mark {
    #[default]
    Whole,
    Name,
    /// Its name and its value.
    Entry,
    /// Some bytes of a string.
    Within(Range<usize>),
}

impl Place {
    /// The whole file.
    pub fn file() -> Self {
        Self::default()
    }

    /// The value of this key.
    #[must_use]
    pub fn key(&self, key: &str) -> Self {
        self.and(Segment::Key(key.to_owned()))
    }

    /// The element with this index.
    #[must_use]
    pub fn index(&self, index: usize) -> Self {
        self.and(Segment::Index(index))
    }

    /// These bytes of the string at this place.
    #[must_use]
    pub fn within(&self, bytes: Range<usize>) -> Self {
        Self { path: self.path.clone(), mark: Mark::Within(bytes) }
    }

    /// The name of the item instead of its value.
    pub(crate) fn name(&self) -> Self {
        Self { path: self.path.clone(), mark: Mark::Name }
    }

    /// The value of this key, with the key.
    #[must_use]
    pub fn entry(&self, key: &str) -> Self {
        Self { mark: Mark::Entry, ..self.key(key) }
    }

    fn and(&self, segment: Segment) -> Self {
        let mut path = self.path.clone();
        path.push(segment);
        Self { path, mark: Mark::Whole }
    }

    /// The bytes of the value, or of its nearest existing parent.
    pub fn locate(&self, text: &str) -> Range<usize> {
        let first_line = 0..text.find('\n').unwrap_or(text.len());
        let Ok(document) = DeTable::parse(text) else { return first_line };
        let mut found = first_line;
        let mut table = Some(document.get_ref());
        let mut value: Option<&DeValue<'_>> = None;
        let mut named = None;
        for segment in &self.path {
            let (name, next) = match segment {
                Segment::Key(key) => {
                    let pair = table.and_then(|table| table.get_key_value(key.as_str()));
                    (pair.map(|(name, _)| name.span()), pair.map(|(_, next)| next))
                }
                Segment::Index(index) => {
                    let array = value.and_then(DeValue::as_array);
                    (None, array.and_then(|array| array.get(*index)))
                }
            };
            let Some(next) = next else { return found };
            found = next.span();
            named = name;
            value = Some(next.get_ref());
            table = next.get_ref().as_table();
        }
        match (&self.mark, named) {
            (Mark::Within(within), _) => inside(&found, within, text).unwrap_or(found),
            (Mark::Name, Some(name)) => name,
            (Mark::Entry, Some(name)) => name.start..found.end,
            (Mark::Whole | Mark::Name | Mark::Entry, _) => found,
        }
    }
}

/// The bytes of a part of the string at `span`, which includes its quotes; `None` if it has escapes or line breaks.
fn inside(span: &Range<usize>, within: &Range<usize>, text: &str) -> Option<Range<usize>> {
    let written = text.get(span.clone())?;
    let quotes = ["\"\"\"", "'''", "\"", "'"].into_iter().find(|one| written.starts_with(one))?;
    let has_escapes = quotes.starts_with('"') && written.contains('\\');
    let start = span.start + quotes.len();
    (!has_escapes && !written.contains('\n'))
        .then(|| start + within.start..(start + within.end).min(span.end))
}

/// The first of these keys that a table has.
macro_rules! given {
    ($table:expr; $($key:ident),+) => {
        [$((stringify!($key), $table.$key.is_some())),+]
            .into_iter()
            .find_map(|(key, is_given)| is_given.then_some(key))
    };
}
pub(crate) use given;

#[cfg(test)]
mod tests {
    use super::Place;

    const TEXT: &str =
        "name = \"oven\"\n[state.a]\nrate = \"1 + b\"\nesc = \"\\u0031 + b\"\nlist = [1, 22]\n";

    fn at(place: &Place) -> &'static str {
        &TEXT[place.locate(TEXT)]
    }

    #[test]
    fn a_path_leads_to_its_value() {
        let state = Place::file().key("state").key("a");
        assert_eq!(at(&state.key("rate")), "\"1 + b\"");
        assert_eq!(at(&state.key("rate").within(4..5)), "b");
        assert_eq!(at(&state.key("list").index(1)), "22");
        assert_eq!(at(&state.key("list").name()), "list");
        assert_eq!(at(&state.name()), "a");
        // With an escape the positions differ: the whole is shown.
        assert_eq!(at(&state.key("esc").within(4..5)), "\"\\u0031 + b\"");
    }

    #[test]
    fn what_is_not_there_is_shown_one_above() {
        let state = Place::file().key("state").key("a");
        assert_eq!(at(&state.key("value")), "[state.a]");
        assert_eq!(at(&Place::file().key("dbc")), "name = \"oven\"");
    }
}
