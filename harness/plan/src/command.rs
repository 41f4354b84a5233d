//! The command line of a device under test.
//!
//! The command line is a list of words, the program first. `{gyro}` and `{base}` in a word stand for the ports of this
//! run; a literal brace is doubled. No shell is involved, so nothing needs quoting.

use std::collections::BTreeMap;

/// Why a command line cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
pub enum CommandError {
    /// The command line is empty.
    #[error("failed to find a program in an empty command line")]
    Empty,
    /// A placeholder names a port that the bench does not have.
    #[error("failed to fill {{{name}}} in the word {word:?}: the bench has no such port")]
    #[diagnostic(help("ports of this bench: {known}; a brace itself is written twice"))]
    UnknownPort {
        /// The name in braces.
        name: String,
        /// The word.
        word: String,
        /// The existing ports.
        known: String,
    },
    /// A brace without its counterpart.
    #[error("failed to read the word {word:?}: a brace without its counterpart")]
    #[diagnostic(help("a brace itself is written twice"))]
    LoneBrace {
        /// The word.
        word: String,
    },
}

/// Returns the words with every placeholder replaced by the port of that name.
///
/// # Errors
/// When there are no words, a placeholder names no port, or a brace stands alone.
pub fn fill<W: AsRef<str>>(
    words: &[W],
    ports: &BTreeMap<String, String>,
) -> Result<Vec<String>, CommandError> {
    if words.first().is_none_or(|program| program.as_ref().is_empty()) {
        return Err(CommandError::Empty);
    }
    words.iter().map(|word| fill_word(word.as_ref(), ports)).collect()
}

fn fill_word(word: &str, ports: &BTreeMap<String, String>) -> Result<String, CommandError> {
    let mut filled = String::with_capacity(word.len());
    let mut rest = word;
    while let Some(at) = rest.find(['{', '}']) {
        let (before, brace) = rest.split_at(at);
        filled.push_str(before);
        rest = if let Some(after) = brace.strip_prefix("{{") {
            filled.push('{');
            after
        } else if let Some(after) = brace.strip_prefix("}}") {
            filled.push('}');
            after
        } else {
            let inside = brace.strip_prefix('{').and_then(|inside| inside.split_once('}'));
            let (name, after) =
                inside.ok_or_else(|| CommandError::LoneBrace { word: word.to_owned() })?;
            let port = ports.get(name).ok_or_else(|| CommandError::UnknownPort {
                name: name.to_owned(),
                word: word.to_owned(),
                known: ports.keys().map(String::as_str).collect::<Vec<_>>().join(", "),
            })?;
            filled.push_str(port);
            after
        };
    }
    filled.push_str(rest);
    Ok(filled)
}

#[cfg(test)]
mod tests {
    use super::{CommandError, fill};
    use proptest::prelude::*;
    use std::collections::BTreeMap;

    fn ports() -> BTreeMap<String, String> {
        [("gyro", "/dev/pts/3"), ("base", "/dev/pts/4")]
            .map(|(name, path)| (name.to_owned(), path.to_owned()))
            .into()
    }

    #[test]
    fn ports_are_filled_in_and_doubled_braces_are_braces() {
        let ours = ["k2a-controller", "--gyro", "{gyro}", "--base", "serial:{base}"];
        let filled = fill(&ours, &ports()).unwrap();
        assert_eq!(filled.join(" "), "k2a-controller --gyro /dev/pts/3 --base serial:/dev/pts/4");
        let filled = fill(&["x", "{{\"id\":{gyro}}}", "{gyro}{base}"], &ports()).unwrap();
        assert_eq!(filled, ["x", "{\"id\":/dev/pts/3}", "/dev/pts/3/dev/pts/4"]);
    }

    #[test]
    fn what_cannot_be_filled_is_named() {
        assert_eq!(fill::<&str>(&[], &ports()), Err(CommandError::Empty));
        assert_eq!(fill(&["", "x"], &ports()), Err(CommandError::Empty));
        let error = fill(&["x", "--port={table}"], &ports()).unwrap_err();
        assert!(error.to_string().contains("{table}"), "{error}");
        for word in ["{", "}", "{gyro", "gyro}", "{{}"] {
            assert!(
                matches!(fill(&["x", word], &ports()), Err(CommandError::LoneBrace { .. })),
                "{word}"
            );
        }
    }

    proptest! {
        #[test]
        fn a_word_with_its_braces_doubled_is_itself(word in "[a-z{}/ é]{0,20}") {
            let doubled = word.replace('{', "{{").replace('}', "}}");
            prop_assert_eq!(fill(&["x".to_owned(), doubled], &ports()).unwrap(), ["x".to_owned(), word]);
        }
    }
}
