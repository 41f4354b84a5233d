//! The mistake in a TOML file and its position, from its parser's error.

use std::ops::Range;

/// Message for tables nested deeper than the parser accepts.
const TOO_DEEP: &str = "nested too deeply: more than 80 levels";

/// The position, if any, and the message of a parser's error.
pub(crate) fn toml_mistake(text: &str, error: &toml::de::Error) -> (Option<Range<usize>>, String) {
    let (at, message) = match error.message() {
        // The parser gives no position for a key of too many parts.
        "recursion limit" => (longest_key(text), TOO_DEEP),
        "cannot recurse further; max recursion depth met" => (error.span(), TOO_DEEP),
        message => (error.span(), message),
    };
    // A mistake at the end of the file is shown at the last letter.
    let last = text.trim_end().char_indices().next_back().map_or(0, |(index, _)| index);
    let at = at.map(|at| at.start.min(last)..at.end.min(text.len()));
    (at, message.to_owned())
}

/// The key with the most parts, if any has several.
fn longest_key(text: &str) -> Option<Range<usize>> {
    let mut begin = 0;
    let keys = text.split_inclusive('\n').map(|line| {
        let at = begin;
        begin += line.len();
        let key = line.split('=').next().unwrap_or_default().trim_end();
        (key.matches('.').count(), at..at + key.len())
    });
    let longest = keys.max_by_key(|(dots, _)| *dots);
    longest.filter(|(dots, _)| *dots > 0).map(|(_, key)| key)
}

#[cfg(test)]
mod tests {
    use super::{TOO_DEEP, toml_mistake};

    fn mistake(text: &str) -> (usize, String) {
        let error = toml::from_str::<toml::Table>(text).unwrap_err();
        let (at, message) = toml_mistake(text, &error);
        let at = at.unwrap();
        assert!(text.get(at.clone()).is_some(), "{at:?}");
        (at.start, message)
    }

    #[test]
    fn what_is_too_deep_is_shown_in_its_place() {
        let key = ["a"; 200].join(".");
        let brackets = "[".repeat(200);
        for (line, column) in
            [(format!("{key} = 1"), 0), (format!("[{key}]"), 0), (format!("a = {brackets}"), 84)]
        {
            let text = format!("name = \"x.y\"\n{line}\nend = 1.5\n");
            assert_eq!(mistake(&text), (13 + column, TOO_DEEP.to_owned()), "{line}");
        }
    }

    #[test]
    fn what_is_missing_at_the_end_is_shown_at_the_last_letter() {
        assert_eq!(mistake("a = 1\nb =\n\n").0, 8);
    }
}
