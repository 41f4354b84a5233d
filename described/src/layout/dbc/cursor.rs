//! Sequential reading of words, numbers and strings in a DBC.

use std::ops::Range;

/// A mismatch with the expected content, and its position.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Unexpected {
    pub(super) at: Range<usize>,
    pub(super) expected: String,
}

/// A position in the text that moves forward.
#[derive(Debug, Clone)]
pub(super) struct Cursor<'a> {
    text: &'a str,
    at: usize,
}

/// Marks that never occur in a word.
const MARKS: &[char] = &[':', ';', ',', '|', '@', '(', ')', '[', ']', '"'];

impl<'a> Cursor<'a> {
    pub(super) const fn new(text: &'a str) -> Self {
        Self { text, at: 0 }
    }

    /// The position of the next content, after blanks and `// comments`.
    pub(super) fn place(&mut self) -> usize {
        loop {
            let rest = self.rest();
            self.at = self.text.len() - rest.trim_start().len();
            match self.rest().strip_prefix("//") {
                Some(comment) => self.at += 2 + comment.find('\n').unwrap_or(comment.len()),
                None => return self.at,
            }
        }
    }

    /// The position after the last content read.
    pub(super) const fn behind(&self) -> usize {
        self.at
    }

    pub(super) fn is_at_end(&mut self) -> bool {
        self.place() == self.text.len()
    }

    /// True if a new line has begun since the last content read.
    pub(super) fn begins_a_line(&mut self) -> bool {
        let place = self.place();
        let line = self.text[..place].rfind('\n').map_or(0, |end| end + 1);
        self.text[line..place].trim_start().is_empty()
    }

    /// Reports that the content at the current position is not `expected`.
    pub(super) fn unexpected(&mut self, expected: impl Into<String>) -> Unexpected {
        let start = self.place();
        let rest = self.rest();
        let first = rest.chars().next().map_or(0, char::len_utf8);
        let length = self.peek().len().max(first);
        Unexpected { at: start..start + length, expected: expected.into() }
    }

    /// The next word, without taking it; empty before a mark.
    pub(super) fn peek(&mut self) -> &'a str {
        self.place();
        let rest = self.rest();
        let end = rest.find(|c: char| c.is_whitespace() || MARKS.contains(&c));
        &rest[..end.unwrap_or(rest.len())]
    }

    /// The next word.
    pub(super) fn word(&mut self, expected: &str) -> Result<&'a str, Unexpected> {
        match self.peek() {
            "" => Err(self.unexpected(expected)),
            word => {
                self.at += word.len();
                Ok(word)
            }
        }
    }

    /// Takes the mark if it is next.
    pub(super) fn takes(&mut self, mark: char) -> bool {
        self.place();
        let comes = self.rest().starts_with(mark);
        self.at += if comes { mark.len_utf8() } else { 0 };
        comes
    }

    /// Takes the mark, which must be next.
    pub(super) fn mark(&mut self, mark: char, expected: &str) -> Result<(), Unexpected> {
        if self.takes(mark) { Ok(()) } else { Err(self.unexpected(expected)) }
    }

    /// A whole number without a sign.
    pub(super) fn whole(&mut self, expected: &str) -> Result<u64, Unexpected> {
        self.place();
        let rest = self.rest();
        let digits = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
        match rest[..digits].parse() {
            Ok(number) => {
                self.at += digits;
                Ok(number)
            }
            Err(_) => Err(self.unexpected(expected)),
        }
    }

    /// A number. Some tools write `1.#QNAN` for NaN: that is refused too.
    pub(super) fn number(&mut self, expected: &str) -> Result<f64, Unexpected> {
        let word = self.peek();
        let begins = |c: char| c.is_ascii_digit() || ['+', '-', '.'].contains(&c);
        let number = match word.parse() {
            Ok(number) => number,
            Err(_) if word.contains(".#") && word.starts_with(begins) => f64::NAN,
            Err(_) => return Err(self.unexpected(expected)),
        };
        self.at += word.len();
        Ok(number)
    }

    /// A quoted text, which may span lines; `\"` is a quote in it.
    pub(super) fn string(&mut self, expected: &str) -> Result<String, Unexpected> {
        let start = self.place();
        if !self.takes('"') {
            return Err(self.unexpected(expected));
        }
        let rest = self.rest();
        let is_end = |(at, _): &(usize, &str)| !rest[..*at].ends_with('\\');
        let Some((end, _)) = rest.match_indices('"').find(is_end) else {
            let line = rest.lines().next().unwrap_or_default();
            let expected = "a quotation mark at the end of the text that begins here".to_owned();
            return Err(Unexpected { at: start..start + 1 + line.len(), expected });
        };
        self.at += end + 1;
        Ok(rest[..end].replace("\\\"", "\""))
    }

    /// Skips to the end of a statement: after the next `;`, or before the next line that starts with a word accepted
    /// by `begins`.
    pub(super) fn skip_statement(&mut self, begins: impl Fn(&str) -> bool) {
        while !self.is_at_end() {
            if self.rest().starts_with('"') {
                if self.string("").is_err() {
                    self.at += 1;
                }
            } else if self.takes(';') || (self.begins_a_line() && begins(self.peek())) {
                return;
            } else {
                let first = self.rest().chars().next().map_or(0, char::len_utf8);
                self.at += self.peek().len().max(first);
            }
        }
    }

    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }
}

#[cfg(test)]
mod tests {
    use super::Cursor;

    #[test]
    fn numbers_are_those_that_tools_write() {
        let number = |text| Cursor::new(text).number("a number").unwrap();
        assert_eq!(number(" 1E-05,"), 1e-5);
        assert_eq!(number("-.5)"), -0.5);
        assert_eq!(number("+1.e3]"), 1000.0);
        assert!(number("-1.#IND|").is_nan());
        let unexpected = Cursor::new("(x1,0)").number("a number").unwrap_err();
        assert_eq!((unexpected.at, unexpected.expected.as_str()), (0..1, "a number"));
    }

    #[test]
    fn a_text_ends_at_its_quotation_mark() {
        let mut cursor = Cursor::new(" \"a \\\"b\\\" // c\nd\" ;");
        assert_eq!(cursor.string("a text").unwrap(), "a \"b\" // c\nd");
        assert!(cursor.takes(';') && cursor.is_at_end());
        let open = Cursor::new("  \"abc\nBO_").string("a text").unwrap_err();
        assert_eq!(open.at, 2..6);
    }

    #[test]
    fn a_statement_is_left_at_its_end_or_where_the_next_begins() {
        let mut cursor = Cursor::new("a \"b;\" c; BO_ 1");
        cursor.skip_statement(|word| word == "BO_");
        assert_eq!(cursor.peek(), "BO_");
        let mut cursor = Cursor::new("a BO_\n// BO_\n BO_ 1");
        cursor.skip_statement(|word| word == "BO_");
        assert_eq!(cursor.place(), 14);
    }
}
