//! Makes text from files safe for a terminal: it moves no cursor, clears no screen and sets no title.

use std::borrow::Cow;
use std::fmt::Write as _;

/// Escapes control characters except line ends, tabs and colours: our tables have colours.
pub(super) fn tamed(text: &str) -> Cow<'_, str> {
    written_out(text, colour_bytes)
}

/// Escapes control characters including colours: for text from outside.
pub(super) fn plain(text: &str) -> Cow<'_, str> {
    written_out(text, |_| 0)
}

/// Escapes control characters, except the bytes that `passing` counts as allowed.
fn written_out(text: &str, passing: impl Fn(&str) -> usize) -> Cow<'_, str> {
    if !text.chars().any(is_wild) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    let mut rest = text;
    while let Some(next) = rest.chars().next() {
        let kept = passing(rest);
        let (head, tail) = rest.split_at(if kept > 0 { kept } else { next.len_utf8() });
        if kept == 0 && is_wild(next) {
            // Escaped as in JSON, so that a document stays valid. Writing to a string cannot fail.
            let _ = write!(out, "\\u{:04x}", u32::from(next));
        } else {
            out.push_str(head);
        }
        rest = tail;
    }
    Cow::Owned(out)
}

/// Whether a terminal may interpret it as a control character.
fn is_wild(c: char) -> bool {
    c.is_control() && !matches!(c, '\n' | '\t')
}

/// Length in bytes of the colour sequence (SGR) at the start of the text; zero without one.
fn colour_bytes(text: &str) -> usize {
    let Some(rest) = text.strip_prefix("\u{1b}[") else { return 0 };
    let end = rest.find(|c: char| !c.is_ascii_digit() && c != ';');
    end.filter(|end| rest[*end..].starts_with('m')).map_or(0, |end| 2 + end + 1)
}

#[cfg(test)]
mod tests {
    use super::{plain, tamed};

    #[test]
    fn only_lines_tabs_and_colours_pass() {
        let own = "\u{1b}[1;31mfail\u{1b}[0m\ta\n";
        assert_eq!(tamed(own), own);
        let theirs = "a\u{1b}[2Jb\u{1b}]0;title\u{7}c\rd\u{9b}e\u{1b}";
        let shown = r"a\u001b[2Jb\u001b]0;title\u0007c\u000dd\u009be\u001b";
        assert_eq!(tamed(theirs), shown);
        let quoted = serde_json::to_string(theirs).unwrap();
        assert_eq!(serde_json::from_str::<String>(&tamed(&quoted)).unwrap(), theirs);
        assert_eq!(plain(theirs), shown);
        assert_eq!(plain("\u{1b}[31mred\n"), "\\u001b[31mred\n");
    }
}
