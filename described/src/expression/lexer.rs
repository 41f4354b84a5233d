//! Tokens of an expression, with their positions.

use super::ExpressionError;
use std::ops::Range;
use wire::digits::number_length;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Token<'a> {
    Number(f64),
    /// A name, possibly with its message: `Command.Setpoint`.
    Name(&'a str),
    /// The name of a value, in single or double quotes.
    Text(&'a str),
    /// An operator, a parenthesis or a comma.
    Symbol(&'a str),
    End,
}

/// Longer symbols first.
const SYMBOLS: [&str; 17] =
    ["<=", ">=", "==", "!=", "<", ">", "+", "-", "*", "/", "%", "^", "(", ")", ",", "[", "]"];

/// Symbols of other languages, and their equivalents here.
const ELSEWHERE: [(&str, &str); 6] =
    [("**", "^"), ("&&", "and"), ("||", "or"), ("!", "not"), ("=", "=="), ("?", "if(a, b, c)")];

/// The token at `from`, after blanks, and its position.
pub(super) fn token(text: &str, from: usize) -> Result<(Token<'_>, Range<usize>), ExpressionError> {
    let rest = text.get(from..).unwrap_or_default();
    let start = from + (rest.len() - rest.trim_start().len());
    let rest = rest.trim_start();
    let Some(first) = rest.chars().next() else { return Ok((Token::End, start..start)) };
    if let Some(digits) = rest.strip_prefix("0x") {
        let length = digits.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(digits.len());
        let at = start..start + 2 + length;
        let number = u64::from_str_radix(&digits[..length], 16).map_err(|_| ExpressionError {
            at: at.clone(),
            message: format!("`{}` is not a hexadecimal number", &text[at.clone()]),
            help: None,
        })?;
        return Ok((Token::Number(number as f64), at));
    }
    if first.is_ascii_digit() || first == '.' {
        let at = start..start + number_length(rest.as_bytes());
        let number = text[at.clone()].parse().map_err(|_| ExpressionError {
            at: at.clone(),
            message: format!("`{}` is not a number", &text[at.clone()]),
            help: None,
        })?;
        return Ok((Token::Number(number), at));
    }
    if first.is_ascii_alphabetic() || first == '_' {
        let part = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '.';
        let length = rest.find(|c| !part(c)).unwrap_or(rest.len());
        return Ok((Token::Name(&rest[..length]), start..start + length));
    }
    if let quote @ ('"' | '\'') = first {
        let Some(length) = rest[1..].find(quote) else {
            let message = "a quote without its end".to_owned();
            return Err(ExpressionError { at: start..text.len(), message, help: None });
        };
        return Ok((Token::Text(&rest[1..=length]), start..start + length + 2));
    }
    for (foreign, ours) in ELSEWHERE {
        if rest.starts_with(foreign) && !rest.starts_with("==") && !rest.starts_with("!=") {
            return Err(ExpressionError {
                at: start..start + foreign.len(),
                message: format!("no operator `{foreign}`"),
                help: Some(format!("write `{ours}`")),
            });
        }
    }
    for symbol in SYMBOLS {
        if rest.starts_with(symbol) {
            return Ok((Token::Symbol(symbol), start..start + symbol.len()));
        }
    }
    Err(ExpressionError {
        at: start..start + first.len_utf8(),
        message: format!("`{first}` means nothing here"),
        help: Some("names have letters, digits and `_`".to_owned()),
    })
}
