//! Lines of text: one pattern writes and reads them.
//!
//! A pattern is text with fields in braces: `T={Temperature:.2} H={HeaterOn:.0}\r\n`. The colon is followed by optional
//! parts: `+` (always a sign), `0` (padding with zeros instead of blanks), the width, the number of decimals after a
//! point, and `E` for an exponent. `{{` and `}}` are literal braces. `{checksum}` are the hexadecimal digits of a
//! checksum, as in NMEA 0183: `$HEHDT,{Heading:.1},T*{checksum}\r\n`.

use super::printed::{Format, Match, number_length};
use crate::protection::Checksum;
use std::ops::Range;
use thiserror::Error;
use wire::packet::Packet;

/// The name of the field that is the checksum.
const CHECKSUM: &str = "checksum";

#[derive(Debug, Clone, PartialEq)]
enum Part {
    Literal(Vec<u8>),
    /// A number: the index of the field.
    Number(usize),
    Digits(TextChecksum),
}

/// A checksum in upper-case hexadecimal digits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TextChecksum {
    pub(crate) checksum: Checksum,
    /// The characters between which it covers the line; `None` for all that is before it.
    pub(crate) between: Option<[u8; 2]>,
}

impl TextChecksum {
    const fn digits(self) -> usize {
        2 * self.checksum.length()
    }

    /// The digits for a line that begins so.
    fn of(self, before: &[u8]) -> String {
        let covered = match self.between {
            None => before,
            Some([first, last]) => {
                let from = before.iter().position(|byte| *byte == first).map_or(0, |at| at + 1);
                let to = before.iter().rposition(|byte| *byte == last).unwrap_or(before.len());
                before.get(from..to).unwrap_or_default()
            }
        };
        format!("{:0width$X}", self.checksum.value(covered), width = self.digits())
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Field {
    pub(crate) name: String,
    pub(crate) format: Format,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Pattern {
    parts: Vec<Part>,
    pub(crate) fields: Vec<Field>,
}

/// Reason why a text is not a pattern.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub(crate) enum PatternError {
    #[error("a brace without its other half; a brace itself is written twice")]
    Brace,
    #[error("`{{{0}}}` is not a field: a name, then `:+08.3` or `:+.4E` where it is formatted")]
    Field(String),
    #[error("`{0}` and what follows it cannot be told apart: put text between them")]
    Ambiguous(String),
    #[error("the line has no end: let it end in `\\r\\n` or `\\n`")]
    NoEnd,
    #[error("`{0}` stands in the line twice")]
    Twice(String),
    #[error("the line has no `{{checksum}}`: it says where the digits are")]
    NoChecksum,
    #[error("behind `{{checksum}}` comes text alone")]
    BehindChecksum,
    #[error("`{0}` does not stand in the text before the checksum")]
    NotBetween(char),
}

impl Pattern {
    pub(crate) fn parse(text: &str, checksum: Option<TextChecksum>) -> Result<Self, PatternError> {
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
            match checksum.filter(|_| field == CHECKSUM) {
                Some(checksum) => pattern.push_checksum(checksum)?,
                None => pattern.push_field(field)?,
            }
            rest = after;
        }
        literal.extend_from_slice(rest.as_bytes());
        pattern.push_literal(&mut literal)?;
        if checksum.is_some() && pattern.checksum().is_none() {
            return Err(PatternError::NoChecksum);
        }
        match pattern.parts.last() {
            Some(Part::Literal(end)) if end.ends_with(b"\n") || end.ends_with(b"\r") => Ok(pattern),
            _ => Err(PatternError::NoEnd),
        }
    }

    /// Whether its first character begins a line wherever it stands, as `$` does in NMEA 0183: a letter or a digit may be in
    /// the middle of another line, as `SET 5` is the end of `RESET 5`.
    pub(crate) fn has_start(&self) -> bool {
        let Some(Part::Literal(text)) = self.parts.first() else { return false };
        text.first().is_some_and(|first| !first.is_ascii_alphanumeric() && *first != b' ')
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

    fn push_checksum(&mut self, checksum: TextChecksum) -> Result<(), PatternError> {
        self.ends_in_text()?;
        let has = |wanted: u8| {
            let mut parts = self.parts.iter();
            parts.any(|part| matches!(part, Part::Literal(text) if text.contains(&wanted)))
        };
        if let Some(lacking) = checksum.between.into_iter().flatten().find(|end| !has(*end)) {
            return Err(PatternError::NotBetween(char::from(lacking)));
        }
        self.parts.push(Part::Digits(checksum));
        Ok(())
    }

    /// Numbers and checksums have text before them.
    fn ends_in_text(&self) -> Result<(), PatternError> {
        if self.checksum().is_some() {
            return Err(PatternError::BehindChecksum);
        }
        match self.parts.last() {
            Some(Part::Number(index)) => {
                Err(PatternError::Ambiguous(self.fields[*index].name.clone()))
            }
            _ => Ok(()),
        }
    }

    fn push_field(&mut self, field: &str) -> Result<(), PatternError> {
        self.ends_in_text()?;
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
            Part::Digits(checksum) => checksum.digits(),
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
                Part::Digits(checksum) => {
                    let digits = checksum.of(line.as_slice());
                    line.extend(digits.as_bytes())
                }
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
        let (mut at, mut is_sound) = (0, true);
        for part in &self.parts {
            let rest = &data[at..];
            at += match part {
                Part::Literal(text) if rest.starts_with(text) => text.len(),
                Part::Literal(text) if text.starts_with(rest) => return Match::Partial,
                Part::Literal(_) => return Match::No,
                Part::Digits(checksum) => {
                    let digits = &rest[..checksum.digits().min(rest.len())];
                    if !digits.iter().all(u8::is_ascii_hexdigit) {
                        return Match::No;
                    }
                    if digits.len() < checksum.digits() {
                        return Match::Partial;
                    }
                    is_sound = digits.eq_ignore_ascii_case(checksum.of(&data[..at]).as_bytes());
                    digits.len()
                }
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
        if is_sound { Match::Whole(at) } else { Match::WrongChecksum(at) }
    }

    /// The checksum in the line, if it has one.
    pub(crate) fn checksum(&self) -> Option<TextChecksum> {
        self.parts.iter().find_map(|part| match part {
            Part::Digits(checksum) => Some(*checksum),
            _ => None,
        })
    }

    /// The places of the checksum's digits in a line of this length.
    pub(crate) fn digits(&self, length: usize) -> Option<Range<usize>> {
        let digits = self.checksum()?.digits();
        let Some(Part::Literal(end)) = self.parts.last() else { return None };
        let end = length.checked_sub(end.len())?;
        Some(end.checked_sub(digits)?..end)
    }
}

#[cfg(test)]
mod tests {
    use super::{Checksum, Match, Pattern, PatternError, TextChecksum};
    use proptest::prelude::*;
    use wire::packet::BYTES_MAX;

    const READING: &str = "T={Temperature:.2} H={HeaterOn:.0}\r\n";

    fn line(pattern: &str, numbers: &[f64]) -> String {
        let packet = Pattern::parse(pattern, None).unwrap().write(|index| numbers[index]).unwrap();
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
        let error = |text| Pattern::parse(text, None).unwrap_err();
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
        let pattern = Pattern::parse(READING, None).unwrap();
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

    const HEADING: &str = "$HEHDT,{Heading:.1},T*{checksum}\r\n";

    fn nmea() -> TextChecksum {
        let checksum = Checksum::named("xor8").unwrap();
        TextChecksum { checksum, between: Some([b'$', b'*']) }
    }

    #[test]
    fn a_checksum_is_that_of_nmea_0183() {
        let pattern = Pattern::parse(HEADING, Some(nmea())).unwrap();
        let written = pattern.write(|_| 274.1).unwrap();
        // The exclusive or of HEHDT,274.1,T.
        assert_eq!(written.as_slice(), b"$HEHDT,274.1,T*2F\r\n");
        assert_eq!(pattern.digits(written.len()), Some(15..17));
        let mut numbers = Vec::new();
        for (line, found) in [
            ("$HEHDT,274.1,T*2F\r\n", Match::Whole(19)),
            ("$HEHDT,274.2,T*2F\r\n", Match::WrongChecksum(19)),
            ("$HEHDT,274.1,T*2", Match::Partial),
            ("$HEHDT,274.1,T*2G\r\n", Match::No),
        ] {
            assert_eq!(pattern.read(line.as_bytes(), &mut numbers), found, "{line}");
        }
        let lower = Checksum::named("crc16-modbus").unwrap();
        let all = TextChecksum { checksum: lower, between: None };
        let pattern = Pattern::parse("A{x:.0};{checksum}\n", Some(all)).unwrap();
        let written = pattern.write(|_| 7.0).unwrap();
        let small = written.as_slice().to_ascii_lowercase();
        assert_eq!(pattern.read(&[b"A", &small[1..]].concat(), &mut numbers), Match::Whole(8));
    }

    #[test]
    fn a_checksum_has_its_place() {
        let error = |text| Pattern::parse(text, Some(nmea())).unwrap_err();
        assert_eq!(error("$T{a}*\n"), PatternError::NoChecksum);
        assert_eq!(error("$T{a}{checksum}\n"), PatternError::Ambiguous("a".to_owned()));
        assert_eq!(error("$*{checksum},{a}\n"), PatternError::BehindChecksum);
        assert_eq!(error("T{a}*{checksum}\n"), PatternError::NotBetween('$'));
    }

    proptest! {
        #[test]
        fn what_is_printed_is_read(a in -1e9f64..1e9, b in -1e9f64..1e9, decimals in 0usize..6) {
            let pattern = format!("a={{a:+012.{decimals}}} b={{b:9.{decimals}}}\r\n");
            let pattern = Pattern::parse(&pattern, None).unwrap();
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
            if let Match::Whole(length) = Pattern::parse(READING, None).unwrap().read(&data, &mut numbers) {
                prop_assert!(length <= data.len() && numbers.len() == 2);
            }
        }
    }
}
