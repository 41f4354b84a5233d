//! Units of parameters: products and quotients of the contract's units, such as `deg/s/(K/s)`.

use crate::dataset::Unit;

/// One of `text` in SI, with degrees Celsius and kelvin alike. `None` if it cannot be read.
///
/// The grammar is that of written units: factors divided by `/`, a divisor of its own in brackets, powers as
/// `K^2` or `K2`.
pub fn si_factor(text: &str) -> Option<f64> {
    let (factor, rest) = quotient(text)?;
    rest.is_empty().then_some(factor)
}

/// The value with three significant digits.
pub(crate) fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    if !(1e-3..1e9).contains(&value.abs()) {
        return format!("{value:.2e}");
    }
    let places = (2.0 - value.abs().log10().floor()).max(0.0) as usize;
    format!("{value:.places$}")
}

/// A time in s in the unit that fits its size: `4.25 ms`, `2.13 h`.
pub(crate) fn lasting(seconds: f64) -> String {
    let (unit, size) = unit_of_time(seconds);
    format!("{} {unit}", short(seconds / size))
}

/// The unit of a time in s that fits its size, and one of it in s.
pub(crate) fn unit_of_time(seconds: f64) -> (&'static str, f64) {
    match seconds.abs() {
        size if size < 1.0 => ("ms", 1e-3),
        size if size < 120.0 => ("s", 1.0),
        size if size < 7200.0 => ("min", 60.0),
        size if size < 172_800.0 => ("h", 3600.0),
        _ => ("days", 86_400.0),
    }
}

fn quotient(text: &str) -> Option<(f64, &str)> {
    let (mut factor, mut rest) = atom(text)?;
    while let Some(after) = rest.strip_prefix('/') {
        let (divisor, next) = atom(after)?;
        factor /= divisor;
        rest = next;
    }
    Some((factor, rest))
}

fn atom(text: &str) -> Option<(f64, &str)> {
    if let Some(inner) = text.strip_prefix('(') {
        let (factor, rest) = quotient(inner)?;
        return power(factor, rest.strip_prefix(')')?);
    }
    let end = text.find(['/', '(', ')', '^']).unwrap_or(text.len());
    let (word, rest) = text.split_at(end);
    power(simple(word)?, rest)
}

fn power(base: f64, rest: &str) -> Option<(f64, &str)> {
    let Some(digits) = rest.strip_prefix('^') else {
        return Some((base, rest));
    };
    let end = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
    let exponent: i32 = digits[..end].parse().ok()?;
    Some((base.powi(exponent), &digits[end..]))
}

fn simple(word: &str) -> Option<f64> {
    match word {
        "K" => Some(1.0),
        "h" => Some(3600.0),
        "min" => Some(60.0),
        "ppm" => Some(1e-6),
        other => Unit::parse(other).map(Unit::si).or_else(|| raised(other)),
    }
}

/// A unit with its power written as a digit: `s2`.
fn raised(word: &str) -> Option<f64> {
    let (place, digit) = word.char_indices().next_back()?;
    let exponent = i32::try_from(digit.to_digit(10)?).ok()?;
    let base = &word[..place];
    if base.is_empty() || base.ends_with(|c: char| c.is_ascii_digit()) {
        return None;
    }
    simple(base).map(|base| base.powi(exponent))
}

/// `numerator` per `denominator`, written.
pub fn per(numerator: &str, denominator: &str) -> String {
    match denominator {
        "1" | "" => numerator.to_owned(),
        simple if !simple.contains('/') => format!("{numerator}/{simple}"),
        compound => format!("{numerator}/({compound})"),
    }
}

#[cfg(test)]
mod tests {
    use super::{lasting, per, short, si_factor};

    #[test]
    fn compound_units_have_their_factor() {
        let deg = std::f64::consts::PI / 180.0;
        for (text, factor) in [
            ("deg/s/(K/s)", deg),
            ("deg/h", deg / 3600.0),
            ("1/K", 1.0),
            ("deg/s/K^2", deg),
            ("1/(deg/s)^2", 1.0 / (deg * deg)),
            ("deg/h/(K/min)", deg / 3600.0 * 60.0),
            ("deg/s/(m/s2)", deg),
            ("1/min2", 1.0 / 3600.0),
        ] {
            let found = si_factor(text).unwrap_or(f64::NAN);
            assert!((found / factor - 1.0).abs() < 1e-12, "{text}: {found}");
        }
        for text in ["", "deg//s", "deg/(s", "furlong", "deg)s", "2", "s12", "s/2"] {
            assert_eq!(si_factor(text), None, "{text}");
        }
        assert_eq!(per("deg/s", "K/s"), "deg/s/(K/s)");
        assert_eq!(per("deg", "1"), "deg");
    }

    #[test]
    fn figures_have_three_digits_and_times_their_unit() {
        assert_eq!([104.87, 0.00480, 12.359].map(short), ["105", "0.00480", "12.4"]);
        assert_eq!([0.00425, 90.0, 7_682.0].map(lasting), ["4.25 ms", "90.0 s", "2.13 h"]);
    }
}
