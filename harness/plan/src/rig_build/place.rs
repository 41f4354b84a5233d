//! Places in a rig file.

use std::ops::Range;

/// The `number`-th table with this name, at its `key` if it has that; the first line if the file uses another notation
/// for its tables.
pub(super) fn place(text: &str, (table, number, key): (&str, usize, &str)) -> Range<usize> {
    let head = format!("[[{table}]]");
    let (begin, whole) = match text.match_indices(&head).nth(number) {
        Some((at, head)) => (at, head.len()),
        None => (0, text.find('\n').unwrap_or(text.len())),
    };
    let rest = &text[begin..];
    let next = rest.match_indices("\n[[").map(|(at, _)| at).find(|at| *at > 0);
    let mut at = begin;
    for line in rest[..next.unwrap_or(rest.len())].split_inclusive('\n') {
        let written = line.trim_start();
        if written.strip_prefix(key).is_some_and(|after| after.trim_start().starts_with('=')) {
            return at..at + line.trim_end().len();
        }
        at += line.len();
    }
    begin..begin + whole
}

#[cfg(test)]
mod tests {
    use super::place;

    #[test]
    fn a_table_and_its_key_are_found() {
        let text = "[[line]]\nname = \"a\"\n[[line]]\n  name = \"b\"\n[[node]]\nname = \"c\"\n";
        let of = |table, number, key| &text[place(text, (table, number, key))];
        assert_eq!(of("line", 1, "name"), "  name = \"b\"");
        assert_eq!(of("line", 1, "at"), "[[line]]");
        assert_eq!(of("node", 0, "name"), "name = \"c\"");
    }

    #[test]
    fn a_file_without_such_tables_has_a_first_line() {
        for (text, first) in [
            ("", ""),
            ("\u{e9}", "\u{e9}"),
            ("line = [{ name = \"a\" }]\n\n", "line = [{ name = \"a\" }]"),
        ] {
            assert_eq!(&text[place(text, ("line", 3, "can"))], first);
        }
    }
}
