//! Lines of text: one pattern writes and reads them.
//!
//! A pattern is text with fields in braces: `T={Temperature:.2} H={HeaterOn:.0}\r\n`. The colon is followed by
//! optional parts: `+` (always a sign), `0` (padding with zeros instead of blanks), the width, and the number of
//! decimals after a point. `{{` and `}}` are literal braces.

use super::printed::{Format, Match, number_length};
use thiserror::Error;
use wire::packet::Packet;

#[derive(Debug, Clone, PartialEq, Eq)]
enum Part {
    Literal(Vec<u8>),
    /// A number: the index of the field.
    Number(usize),
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Field {
    pub(crate) name: String,
    pub(crate) format: Format,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Pattern {
    parts: Vec<Part>,
    pub(crate) fields: Vec<Field>,
}

/// Reason why a text is not a pattern.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub(crate) enum PatternError {
    #[error("a brace without its other half; a brace itself is written twice")]
    Brace,
    #[error("`{{{0}}}` is not a field: a name, then `:+08.3` where it is formatted")]
    Field(String),
    #[error("`{0}` and what follows it cannot be told apart: put text between them")]
    Ambiguous(String),
    #[error("the line has no end: let it end in `\\r\\n` or `\\n`")]
    NoEnd,
    #[error("`{0}` stands in the line twice")]
    Twice(String),
}

impl Pattern {
    pub(crate) fn parse(text: &str) -> Result<Self, PatternError> {
        let mut pattern = Self { parts: Vec::new(), fields: Vec::new() };
        let mut literal = Vec::new();
        let mut rest = text;
        while let Some(at) = rest.find(['{', '}']) {
            literal.extend_from_slice(&rest.as_bytes()[..at]);
            let brace = &rest[at..];
            if let Some(after) = brace.strip_prefix("{{").or_else(|| brace.strip_prefix("}}")) {
                literal.push(brace.as_bytes()[0]);
                rest = after;
                continue;
            }
            let field = brace.strip_prefix('{').ok_or(PatternError::Brace)?;
            let (field, after) = field.split_once('}').ok_or(PatternError::Brace)?;
            pattern.push_literal(&mut literal)?;
            pattern.push_field(field)?;
            rest = after;
        }
        literal.extend_from_slice(rest.as_bytes());
        pattern.push_literal(&mut literal)?;
        match pattern.parts.last() {
            Some(Part::Literal(end)) if end.ends_with(b"\n") || end.ends_with(b"\r") => Ok(pattern),
            _ => Err(PatternError::NoEnd),
        }
    }

    /// Whether the same line may be read as either: all text is the same, and numbers are in the same places.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        self.parts == other.parts
    }

    fn push_literal(&mut self, literal: &mut Vec<u8>) -> Result<(), PatternError> {
        let Some(first) = literal.first() else { return Ok(()) };
        // A number ends at a character that cannot belong to it.
        let continues = first.is_ascii_digit() || matches!(first, b'.' | b'e' | b'E');
        if let (true, Some(Part::Number(index))) = (continues, self.parts.last()) {
            return Err(PatternError::Ambiguous(self.fields[*index].name.clone()));
        }
        self.parts.push(Part::Literal(std::mem::take(literal)));
        Ok(())
    }

    fn push_field(&mut self, field: &str) -> Result<(), PatternError> {
        if let Some(Part::Number(index)) = self.parts.last() {
            return Err(PatternError::Ambiguous(self.fields[*index].name.clone()));
        }
        let (name, format) = field.split_once(':').unwrap_or((field, ""));
        let format = Format::parse(format).filter(|_| !name.is_empty());
        let format = format.ok_or_else(|| PatternError::Field(field.to_owned()))?;
        if self.fields.iter().any(|known| known.name == name) {
            return Err(PatternError::Twice(name.to_owned()));
        }
        self.parts.push(Part::Number(self.fields.len()));
        self.fields.push(Field { name: name.to_owned(), format });
        Ok(())
    }

    /// Maximum length of the line in bytes, with numbers between these ends.
    pub(crate) fn longest(&self, ends: impl Fn(usize) -> [f64; 2]) -> usize {
        let length = |part: &Part| match part {
            Part::Literal(text) => text.len(),
            Part::Number(index) => {
                let longest = ends(*index).map(|end| self.fields[*index].format.longest(end));
                longest[0].max(longest[1])
            }
        };
        self.parts.iter().map(length).sum()
    }

    /// The line with these numbers, one per field; `None` if it is longer than a packet.
    pub(crate) fn write(&self, numbers: impl Fn(usize) -> f64) -> Option<Packet> {
        let mut line = Packet::new();
        for part in &self.parts {
            let fits = match part {
                Part::Literal(text) => line.extend(text),
                // Adding zero removes the sign of a negative zero, which no reader expects.
                Part::Number(index) => {
                    self.fields[*index].format.print(numbers(*index) + 0.0, &mut line)
                }
            };
            if !fits {
                return None;
            }
        }
        Some(line)
    }

    /// Reads the line at the start of `data`, and stores its numbers in `numbers`.
    pub(crate) fn read(&self, data: &[u8], numbers: &mut Vec<f64>) -> Match {
        numbers.clear();
        let mut at = 0;
        for part in &self.parts {
            let rest = &data[at..];
            at += match part {
                Part::Literal(text) if rest.starts_with(text) => text.len(),
                Part::Literal(text) if text.starts_with(rest) => return Match::Partial,
                Part::Literal(_) => return Match::No,
                Part::Number(index) => {
                    let padded = self.fields[*index].format.width > 0;
                    let length = match number_length(rest, padded) {
                        Match::Whole(length) => length,
                        other => return other,
                    };
                    let digits = std::str::from_utf8(&rest[..length]).unwrap_or_default();
                    match digits.trim_start().parse::<f64>() {
                        Ok(number) if number.is_finite() => numbers.push(number),
                        _ => return Match::No,
                    }
                    length
                }
            };
        }
        Match::Whole(at)
    }
}

#[cfg(test)]
mod tests {
    use super::{Match, Pattern, PatternError};
    use proptest::prelude::*;
    use wire::packet::BYTES_MAX;

    const READING: &str = "T={Temperature:.2} H={HeaterOn:.0}\r\n";

    fn line(pattern: &str, numbers: &[f64]) -> String {
        let packet = Pattern::parse(pattern).unwrap().write(|index| numbers[index]).unwrap();
        String::from_utf8(packet.as_slice().to_vec()).unwrap()
    }

    #[test]
    fn formats_are_those_of_the_field() {
        assert_eq!(line(READING, &[21.456, 1.0]), "T=21.46 H=1\r\n");
        assert_eq!(line("{a:+08.3};{{{b:6}}}\n", &[3.5, -2.25]), "+003.500;{ -2.25}\n");
        assert_eq!(line("{a}\n", &[-0.0]), "0\n");
        assert_eq!(line("{a};{b}\n", &[0.1 + 0.2, 1e-30]), "0.3;0\n");
        assert_eq!(line("READ?\r", &[]), "READ?\r");
    }

    #[test]
    fn what_is_no_pattern_says_why() {
        let error = |text| Pattern::parse(text).unwrap_err();
        assert_eq!(error("T={a\n"), PatternError::Brace);
        assert_eq!(error("T=a}\n"), PatternError::Brace);
        assert_eq!(error("{a:.x}\n"), PatternError::Field("a:.x".to_owned()));
        assert_eq!(error("{a:.99}\n"), PatternError::Field("a:.99".to_owned()));
        assert_eq!(error("{}\n"), PatternError::Field(String::new()));
        assert_eq!(error("{a}{b}\n"), PatternError::Ambiguous("a".to_owned()));
        assert_eq!(error("{a}e5\n"), PatternError::Ambiguous("a".to_owned()));
        assert_eq!(error("{a},{a}\n"), PatternError::Twice("a".to_owned()));
        for open in ["", "T=", "{a}", "{a} "] {
            assert_eq!(error(open), PatternError::NoEnd, "{open}");
        }
    }

    #[test]
    fn a_line_is_read_when_it_is_whole() {
        let pattern = Pattern::parse(READING).unwrap();
        let mut numbers = Vec::new();
        let whole = b"T=-2.5e1 H=0\r\n";
        for length in 0..whole.len() {
            assert_eq!(pattern.read(&whole[..length], &mut numbers), Match::Partial, "{length}");
        }
        let mut with_more = whole.to_vec();
        with_more.extend_from_slice(b"T=");
        assert_eq!(pattern.read(&with_more, &mut numbers), Match::Whole(whole.len()));
        assert_eq!(numbers, [-25.0, 0.0]);
        for wrong in ["x", "T=x", "T= 1 H=0\r\n", "T=1. H=1\n", "T=1e H", "T=1e999 H"] {
            assert_eq!(pattern.read(wrong.as_bytes(), &mut numbers), Match::No, "{wrong}");
        }
    }

    proptest! {
        #[test]
        fn what_is_printed_is_read(a in -1e9f64..1e9, b in -1e9f64..1e9, decimals in 0usize..6) {
            let pattern = format!("a={{a:+012.{decimals}}} b={{b:9.{decimals}}}\r\n");
            let pattern = Pattern::parse(&pattern).unwrap();
            let packet = pattern.write(|index| [a, b][index]).unwrap();
            let mut numbers = Vec::new();
            let found = pattern.read(packet.as_slice(), &mut numbers);
            prop_assert_eq!(found, Match::Whole(packet.len()));
            // The resolution of a double at 1e9, for the smallest steps.
            let half = 0.5 * pattern.fields[0].format.resolution() + 1e-6;
            prop_assert!((numbers[0] - a).abs() <= half && (numbers[1] - b).abs() <= half);
        }

        #[test]
        fn no_bytes_make_it_panic(data in prop::collection::vec(
            prop_oneof![any::<u8>(), prop::sample::select(b"T= H0123456789.+-e\r\n".to_vec())], 0..BYTES_MAX
        )) {
            let mut numbers = Vec::new();
            if let Match::Whole(length) = Pattern::parse(READING).unwrap().read(&data, &mut numbers) {
                prop_assert!(length <= data.len() && numbers.len() == 2);
            }
        }
    }
}
