//! The tokens of a formula with their positions.

use crate::mistake::Mistake;
use crate::unit::TIMES;
use std::ops::Range;
use wire::digits::number_length;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Token<'a> {
    Number(f64),
    /// A signal, an operator or a function.
    Name(&'a str),
    /// The text between quotation marks: the name of a value.
    Quoted(&'a str),
    /// An operator, a parenthesis, a comma or a colon.
    Symbol(&'a str),
    End,
}

/// Longer symbols first.
const SYMBOLS: [&str; 24] = [
    "->", "+-", "<=", ">=", "==", "!=", "&&", "||", "±", "<", ">", "+", "-", "*", "/", "(", ")",
    "[", "]", ",", ":", "!", "{", "}",
];

/// Symbols of other languages and their equivalents here.
const ELSEWHERE: [(&str, &str); 6] =
    [("=>", "->"), ("<>", "!="), ("=", "=="), ("&", "and"), ("|", "or"), ("~", "not")];

/// Names reserved for other uses than signals.
pub(super) const KEYWORDS: [&str; 19] = [
    "and",
    "or",
    "not",
    "until",
    "since",
    "within",
    "for",
    "always",
    "eventually",
    "once",
    "historically",
    "rises",
    "falls",
    "changes",
    "sent",
    "abs",
    "min",
    "max",
    "bit_and",
];

/// The token at `from`, after white space, and its position.
pub(super) fn token(text: &str, from: usize) -> Result<(Token<'_>, Range<usize>), Mistake> {
    let rest = text.get(from..).unwrap_or_default();
    let start = from + (rest.len() - rest.trim_start().len());
    let rest = rest.trim_start();
    let Some(first) = rest.chars().next() else { return Ok((Token::End, start..start)) };
    if let Some(digits) = rest.strip_prefix("0x") {
        let length = digits.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(digits.len());
        let at = start..start + "0x".len() + length;
        let mistake = || {
            Mistake::new(at.clone(), format!("`{}` is not a hexadecimal number", &text[at.clone()]))
        };
        let number = u64::from_str_radix(&digits[..length], 16).map_err(|_| mistake())?;
        return Ok((Token::Number(number as f64), at));
    }
    if first.is_ascii_digit() || first == '.' {
        let at = start..start + number_length(rest.as_bytes());
        let word = &text[at.clone()];
        let number = word.parse().ok().filter(|number: &f64| number.is_finite());
        let number =
            number.ok_or_else(|| Mistake::new(at.clone(), format!("`{word}` is not a number")))?;
        return Ok((Token::Number(number), at));
    }
    if first.is_alphabetic() || first == '_' {
        let part = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
        let length = rest.find(|c| !part(c)).unwrap_or(rest.len());
        let length = hyphenated(rest, length).unwrap_or(length);
        return Ok((Token::Name(&rest[..length]), start..start + length));
    }
    if first == '"' {
        let Some(length) = rest[1..].find('"') else {
            let mistake = Mistake::new(start..text.len(), "the name has no end");
            return Err(mistake.help("write a second `\"` behind it"));
        };
        return Ok((Token::Quoted(&rest[1..=length]), start..start + length + 2));
    }
    if let Some(symbol) = SYMBOLS.iter().find(|symbol| rest.starts_with(**symbol)) {
        return Ok((Token::Symbol(symbol), start..start + symbol.len()));
    }
    if let Some((foreign, ours)) = ELSEWHERE.iter().find(|(word, _)| rest.starts_with(word)) {
        let mistake =
            Mistake::new(start..start + foreign.len(), format!("no operator `{foreign}`"));
        return Err(mistake.help(format!("write `{ours}`")));
    }
    let mistake =
        Mistake::new(start..start + first.len_utf8(), format!("`{first}` means nothing here"));
    Err(mistake.help("names have letters, digits, `_` and `.`"))
}

/// Length of a signal whose node has hyphens in its name, `left-door.Open`, if the word of this length begins one. Nothing
/// else is written so: what a difference is of has a node before a point, or is a number.
fn hyphenated(rest: &str, length: usize) -> Option<usize> {
    let (word, behind) = rest.split_at(length);
    let more = behind.strip_prefix('-')?;
    let node = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || matches!(c, '-' | '_');
    let (node, signal) = more.split_at(more.find(|c| !node(c))?);
    let is_name = |c: char| c.is_alphanumeric() || matches!(c, '_' | '.');
    let signal = &signal[..signal.find(|c| !is_name(c)).unwrap_or(signal.len())];
    let is_node = !node.is_empty() && !word.contains('.') && !KEYWORDS.contains(&word);
    (is_node && signal.len() > 1 && signal.starts_with('.'))
        .then_some(length + 1 + node.len() + signal.len())
}

/// The word after a number that may be its unit: letters, `%`, `°`, and digits, `/` or `*` inside; or `1/` and such a
/// word.
pub(super) fn unit_word(text: &str, from: usize) -> Option<Range<usize>> {
    let rest = text.get(from..)?;
    let start = from + (rest.len() - rest.trim_start().len());
    let rest = rest.trim_start();
    let first = |c: char| c.is_alphabetic() || matches!(c, '%' | '°');
    // `/min` would be a division. Behind a number, `1/m` can be nothing else.
    let begin = if start > from { rest.strip_prefix("1/").unwrap_or(rest) } else { rest };
    begin.chars().next().filter(|c| first(*c))?;
    let between = |c: char| c == '/' || TIMES.contains(&c);
    let part = |c: char| first(c) || c.is_numeric() || between(c) || matches!(c, '^' | '_');
    let length = rest.find(|c| !part(c)).unwrap_or(rest.len());
    let word = rest[..length].trim_end_matches(between);
    let letters = word.find(|c: char| !c.is_alphabetic()).unwrap_or(word.len());
    (!KEYWORDS.contains(&&word[..letters]) || word == "min").then_some(start..start + word.len())
}

#[cfg(test)]
mod tests {
    use super::{Token, token};

    fn first(text: &str) -> Token<'_> {
        token(text, 0).unwrap().0
    }

    /// Found by a user: `k-rper.Mode` was read as `k` minus `rper.Mode`, and no writing of the name was taken.
    #[test]
    fn a_node_may_have_hyphens() {
        for name in ["k-rper.Mode", "left-door-2.Lock.State", "a-_b.C"] {
            assert_eq!(first(&format!("{name} > 1")), Token::Name(name));
            assert_eq!(first(&format!("{name}-x.Y")), Token::Name(name), "then it is a difference");
        }
        for (text, name) in
            [("a.B-c.D", "a.B"), ("a - b.C", "a"), ("a-b", "a"), ("a-2", "a"), ("not-a.B", "not")]
        {
            assert_eq!(first(text), Token::Name(name), "{text}");
        }
        assert_eq!(first("5-b.C"), Token::Number(5.0));
    }
}
