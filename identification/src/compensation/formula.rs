//! Arithmetic that is both evaluated and written, so that firmware runs exactly what was judged.

use std::fmt::Write as _;
use std::ops::{Add, Div, Mul, Sub};

/// A formula over the names of a [`Program`](super::Program).
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Formula {
    /// A number, with as many digits as are written.
    Number(f64),
    /// Current value of this name.
    Now(usize),
    /// Value of this name at the previous reading.
    Before(usize),
    /// Two operands joined by `+`, `-`, `*` or `/`.
    Infix(char, Box<[Formula; 2]>),
    /// A small integer power.
    Power(Box<Formula>, i32),
    /// A named function.
    Call(&'static str, Vec<Formula>),
}

/// Significant digits written.
const DIGITS: usize = 9;

/// A number, rounded as it is written.
pub(super) fn number(value: f64) -> Formula {
    let written: f64 = format!("{value:.*e}", DIGITS - 1).parse().unwrap_or(value);
    Formula::Number(written)
}

pub(super) fn call<const N: usize>(name: &'static str, arguments: [Formula; N]) -> Formula {
    Formula::Call(name, arguments.into())
}

impl Formula {
    pub(super) fn power(self, power: i32) -> Self {
        if power == 1 { self } else { Self::Power(Box::new(self), power) }
    }

    pub(super) fn is_zero(&self) -> bool {
        *self == Self::Number(0.0)
    }

    fn is_one(&self) -> bool {
        *self == Self::Number(1.0)
    }

    fn infix(operator: char, left: Self, right: Self) -> Self {
        Self::Infix(operator, Box::new([left, right]))
    }

    /// Evaluates the formula for these values of the names.
    pub(super) fn value(&self, now: &[f64], before: &[f64]) -> f64 {
        let of = |one: &Self| one.value(now, before);
        match self {
            Self::Number(value) => *value,
            Self::Now(name) => now[*name],
            Self::Before(name) => before[*name],
            Self::Infix('+', two) => of(&two[0]) + of(&two[1]),
            Self::Infix('-', two) => of(&two[0]) - of(&two[1]),
            Self::Infix('*', two) => of(&two[0]) * of(&two[1]),
            Self::Infix(_, two) => of(&two[0]) / of(&two[1]),
            Self::Power(base, power) => of(base).powi(*power),
            Self::Call(name, of_these) => {
                let at = |place: usize| of_these.get(place).map_or(f64::NAN, of);
                match *name {
                    "abs" => at(0).abs(),
                    "cos" => at(0).cos(),
                    "sin" => at(0).sin(),
                    "exp" => at(0).exp(),
                    "tanh" => at(0).tanh(),
                    "floor" => at(0).floor(),
                    "max" => at(0).max(at(1)),
                    "min" => at(0).min(at(1)),
                    // Must not panic if a bound is NaN.
                    "clamp" => at(0).max(at(1)).min(at(2)),
                    "at_least" => f64::from(u8::from(at(0) >= at(1))),
                    "sign" if at(0) == 0.0 => 0.0,
                    "sign" => at(0).signum(),
                    _ => f64::NAN,
                }
            }
        }
    }

    /// The formula as text, with these names.
    pub(super) fn text(&self, names: &[String]) -> String {
        let mut text = String::new();
        self.write(names, 0, &mut text);
        text
    }

    /// Writes the formula, in brackets unless it binds at least this tightly: 1 sums, 2 products, 3 powers.
    fn write(&self, names: &[String], tightness: u8, text: &mut String) {
        let mine = match self {
            Self::Infix('+' | '-', _) => 1,
            Self::Infix(..) => 2,
            // A sign binds less tightly than a power.
            Self::Number(value) if *value < 0.0 => 1,
            Self::Power(..) => 3,
            _ => 4,
        };
        let in_brackets = mine < tightness;
        if in_brackets {
            text.push('(');
        }
        match self {
            Self::Number(value) => {
                // Writing to a string cannot fail.
                let _ = match value.abs() {
                    size if size != 0.0 && !(1e-4..1e9).contains(&size) => {
                        write!(text, "{value:e}")
                    }
                    _ => write!(text, "{value}"),
                };
            }
            Self::Now(name) => text.push_str(&names[*name]),
            Self::Before(name) => {
                let _ = write!(text, "{}_before", names[*name]);
            }
            Self::Infix(operator, two) => {
                two[0].write(names, mine, text);
                let _ = write!(text, " {operator} ");
                two[1].write(names, mine + 1, text);
            }
            Self::Power(base, power) => {
                base.write(names, 4, text);
                let _ = write!(text, "^{power}");
            }
            Self::Call("at_least", two) => {
                text.push_str("if(");
                for (place, one) in two.iter().enumerate() {
                    text.push_str(if place == 0 { "" } else { " >= " });
                    one.write(names, 1, text);
                }
                text.push_str(", 1, 0)");
            }
            Self::Call(name, arguments) => {
                text.push_str(name);
                text.push('(');
                for (place, one) in arguments.iter().enumerate() {
                    text.push_str(if place == 0 { "" } else { ", " });
                    one.write(names, 0, text);
                }
                text.push(')');
            }
        }
        if in_brackets {
            text.push(')');
        }
    }
}

impl Add for Formula {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        match (self, other) {
            (left, right) if left.is_zero() => right,
            (left, right) if right.is_zero() => left,
            (left, Self::Number(value)) if value < 0.0 => {
                Self::infix('-', left, Self::Number(-value))
            }
            (left, right) => Self::infix('+', left, right),
        }
    }
}

impl Sub for Formula {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        match (self, other) {
            (left, right) if right.is_zero() => left,
            (left, Self::Number(value)) if value < 0.0 => {
                Self::infix('+', left, Self::Number(-value))
            }
            (left, right) => Self::infix('-', left, right),
        }
    }
}

impl Mul for Formula {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        match (self, other) {
            (left, right) if left.is_zero() || right.is_one() => left,
            (left, right) if right.is_zero() || left.is_one() => right,
            (left, right) => Self::infix('*', left, right),
        }
    }
}

impl Div for Formula {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        if other.is_one() { self } else { Self::infix('/', self, other) }
    }
}

#[cfg(test)]
mod tests {
    use super::{Formula, call, number};

    #[test]
    fn what_is_written_says_what_is_evaluated() {
        let names = ["x".to_owned(), "y".to_owned()];
        let (x, y) = (Formula::Now(0), Formula::Before(1));
        for (formula, text, value) in [
            (x.clone() - (y.clone() - number(2.0)), "x - (y_before - 2)", 3.0 - (5.0 - 2.0)),
            ((x.clone() + y.clone()) * number(-0.5), "(x + y_before) * (-0.5)", -4.0),
            (x.clone() / (y.clone() * number(4.0)), "x / (y_before * 4)", 0.15),
            ((x.clone() - number(-1.0)).power(2), "(x + 1)^2", 16.0),
            (number(0.0) * x.clone() + number(1.0) * y.clone(), "y_before", 5.0),
            (number(1.0 / 3.0) + number(1e-7), "0.333333333 + 1e-7", 0.333_333_433),
            (call("clamp", [x.clone(), number(4.0), y.clone()]), "clamp(x, 4, y_before)", 4.0),
            (call("at_least", [y, x]) * number(2.0), "if(y_before >= x, 1, 0) * 2", 2.0),
        ] {
            assert_eq!(formula.text(&names), text);
            let found = formula.value(&[3.0, f64::NAN], &[f64::NAN, 5.0]);
            assert!((found - value).abs() < 1e-12, "{text}: {found}");
        }
    }
}
