//! Arithmetic with units.

use super::lexer::{Token, unit_word};
use super::{Parser, Part, What};
use crate::formula::Condition;
use crate::mistake::Mistake;
use crate::number::{Binary, Number};
use crate::unit::{TIMES, Unit};
use std::ops::Range;

#[derive(Debug, Clone)]
pub(super) struct Quantity {
    pub(super) number: Number,
    pub(super) measure: Measure,
    pub(super) at: Range<usize>,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Measure {
    /// A number without a unit takes that of its neighbour.
    Bare,
    Known(Unit, String),
    /// A unit that matches only the same text.
    Opaque(String),
    /// A signal without a unit, or a product whose unit is not known.
    None,
}

impl Measure {
    pub(super) fn of(unit: &str) -> Self {
        match (unit.trim(), Unit::parse(unit.trim())) {
            ("", _) => Self::None,
            (text, Some(unit)) => Self::Known(unit, text.to_owned()),
            (text, None) => Self::Opaque(text.to_owned()),
        }
    }

    pub(super) fn text(&self) -> Option<&str> {
        match self {
            Self::Known(_, text) | Self::Opaque(text) => Some(text),
            Self::Bare | Self::None => None,
        }
    }

    fn product(&self, is_over: bool, other: &Self) -> Self {
        let known = |measure: &Self| match measure {
            Self::Known(unit, text) => Some((*unit, text.clone())),
            Self::Bare => Some((Unit::one(), "1".to_owned())),
            Self::Opaque(_) | Self::None => None,
        };
        let (Some((a, left)), Some((b, right))) = (known(self), known(other)) else {
            return Self::None;
        };
        let sign = if is_over { '/' } else { '*' };
        let whole = |text: String| if text.contains('/') { format!("({text})") } else { text };
        let (left, right) = (whole(left), whole(right));
        match if is_over { a.over(b) } else { a.times(b) } {
            Some(unit) => Self::Known(unit, format!("{left}{sign}{right}")),
            None => Self::None,
        }
    }
}

impl Parser<'_> {
    pub(super) fn sum(&mut self) -> Result<Part, Mistake> {
        let mut left = self.product()?;
        loop {
            let binary = match self.next {
                Token::Symbol("+") => Binary::Add,
                Token::Symbol("-") => Binary::Subtract,
                _ => return Ok(left),
            };
            let word = self.said(&self.at);
            self.advance()?;
            let right = self.product()?;
            left = self.computed(binary, left, right, word)?;
        }
    }

    fn product(&mut self) -> Result<Part, Mistake> {
        let mut left = self.signed()?;
        loop {
            let binary = match self.next {
                Token::Symbol("*") => Binary::Multiply,
                Token::Symbol("/") => Binary::Divide,
                _ => return Ok(left),
            };
            let word = self.said(&self.at);
            self.advance()?;
            let right = self.signed()?;
            left = self.computed(binary, left, right, word)?;
        }
    }

    fn computed(
        &self,
        binary: Binary,
        left: Part,
        right: Part,
        word: &str,
    ) -> Result<Part, Mistake> {
        let at = left.at.start..right.at.end;
        let (left, right) = (self.quantity(left, word)?, self.quantity(right, word)?);
        let (left, right, measure) = match binary {
            Binary::Multiply | Binary::Divide => {
                let measure = match (&left.measure, &right.measure) {
                    (measure, Measure::Bare) => measure.clone(),
                    (Measure::Bare, measure) if binary == Binary::Multiply => measure.clone(),
                    (a, b) => a.product(binary == Binary::Divide, b),
                };
                (left, right, measure)
            }
            _ => {
                let (left, right) = self.alike(left, right)?;
                let measure = left.measure.clone();
                (left, right, measure)
            }
        };
        let number = Number::binary(binary, left.number, right.number);
        Ok(Part::quantity(number, measure, at))
    }

    fn signed(&mut self) -> Result<Part, Mistake> {
        if !self.is_symbol("-") {
            return self.primary();
        }
        let start = self.at.start;
        self.advance()?;
        let of = self.deeper(Self::signed)?;
        let at = start..of.at.end;
        let of = self.quantity(of, "-")?;
        let number = of.number.negated();
        Ok(Part::quantity(number, of.measure, at))
    }

    fn primary(&mut self) -> Result<Part, Mistake> {
        let at = self.at.clone();
        match self.next {
            Token::Number(number) => {
                let measure = self.unit()?;
                let at = at.start..self.end;
                Ok(Part::quantity(Number::Constant(number), measure, at))
            }
            Token::Symbol("(") => {
                self.advance()?;
                let inner = self.implication()?;
                self.expect(")")?;
                // Parentheses resolve the ambiguity.
                Ok(Part { what: inner.what, at: at.start..self.end, bare: None, is_open: false })
            }
            Token::Quoted(name) => {
                self.advance()?;
                let what = What::Named(name.to_owned());
                Ok(Part { what, at, bare: None, is_open: false })
            }
            Token::Name(
                name @ ("abs" | "min" | "max" | "bit_and" | "rises" | "falls" | "changes"),
            ) => {
                self.advance()?;
                if !self.is_symbol("(") {
                    return Err(self.unexpected("`(`").help(format!("write `{name}(...)`")));
                }
                self.advance()?;
                self.deeper(|parser| parser.call(name, at.start))
            }
            Token::Name("sent") => {
                self.advance()?;
                self.message(at.start)
            }
            Token::Name(name) => self.signal(name),
            _ => Err(self.unexpected("a signal, a number or `(`")),
        }
    }

    /// A function call, starting after its opening parenthesis.
    fn call(&mut self, name: &str, start: usize) -> Result<Part, Mistake> {
        let mut part = self.implication()?;
        if name == "rises" || name == "falls" {
            self.expect(")")?;
            let of = Box::new(self.condition(part)?);
            let of = if name == "falls" { Box::new(Condition::Not(of)) } else { of };
            return Ok(Part::condition(Condition::Rises(of), start..self.end));
        }
        let mut count = 1;
        let binary = match name {
            "min" => Some(Binary::Min),
            "max" => Some(Binary::Max),
            "bit_and" => Some(Binary::BitAnd),
            _ => None,
        };
        while let Some(binary) = binary.filter(|_| self.is_symbol(",")) {
            self.advance()?;
            let right = self.sum()?;
            part = self.computed(binary, part, right, name)?;
            count += 1;
        }
        self.expect(")")?;
        let at = start..self.end;
        if count == 1 && binary.is_some() {
            let mistake = Mistake::new(at, format!("`{name}` takes two numbers or more"));
            return Err(mistake.help(format!("write `{name}(a, b)`")));
        }
        let of = self.quantity(part, name)?;
        if name == "changes" {
            let width = self.width(&of, &Number::Constant(0.0));
            return Ok(Part::condition(Condition::Changes(of.number, width, f64::NAN), at));
        }
        let number = if name == "abs" { Number::Abs(Box::new(of.number)) } else { of.number };
        Ok(Part::quantity(number, of.measure, at))
    }

    /// Requires a number, because `word` applies to numbers.
    pub(super) fn quantity(&self, part: Part, word: &str) -> Result<Quantity, Mistake> {
        match part.what {
            What::Quantity(quantity) => Ok(quantity),
            What::Condition(_) => {
                let message = format!("`{word}` takes numbers; this is true or false");
                Err(Mistake::new(part.at, message).help("`and`, `or` and `->` join conditions"))
            }
            What::Named(name) => {
                let message = format!("`\"{name}\"` is the name of a value, not a number");
                let help = format!("names stand beside a signal: `signal == \"{name}\"`");
                Err(Mistake::new(part.at, message).help(help))
            }
        }
    }

    /// The unit after a number. Starts at the number and moves past both.
    fn unit(&mut self) -> Result<Measure, Mistake> {
        let Some(at) = unit_word(self.text, self.at.end) else {
            self.advance()?;
            return Ok(Measure::Bare);
        };
        let word = self.said(&at);
        // `4 V/x` divides by x, `4 V*x` multiplies by it: the unit is the known part of the word.
        let between = |c: char| c == '/' || TIMES.contains(&c);
        let known = word.match_indices(between).map(|(cut, _)| cut).chain([word.len()]);
        let length = known.filter(|cut| Unit::parse(&word[..*cut]).is_some()).max();
        let length = length.unwrap_or(word.len());
        self.at = at.start..at.start + length;
        self.advance()?;
        Ok(Measure::of(&word[..length]))
    }

    /// Converts both to one unit if they have the same dimension: that of the left one, or that of the signal beside a
    /// number.
    pub(super) fn alike(
        &self,
        mut left: Quantity,
        mut right: Quantity,
    ) -> Result<(Quantity, Quantity), Mistake> {
        if is_literal(&left) && !is_literal(&right) {
            return self.alike(right, left).map(|(right, left)| (left, right));
        }
        let fit = match (&left.measure, &right.measure) {
            (Measure::Bare, _) | (_, Measure::Bare) => Some((1.0, 0)),
            (Measure::Known(ours, _), Measure::Known(theirs, _)) => theirs.in_terms_of(*ours),
            (Measure::None, _) => (!is_literal(&right)).then_some((1.0, 0)),
            (_, Measure::None) => (!is_literal(&left)).then_some((1.0, 0)),
            (ours, theirs) => (ours == theirs).then_some((1.0, 0)),
        };
        let Some((factor, tens)) = fit else { return Err(self.misfit(&left, &right)) };
        right.number = right.number.scaled(factor, tens);
        match left.measure {
            Measure::Bare | Measure::None => left.measure = right.measure.clone(),
            _ => right.measure = left.measure.clone(),
        }
        Ok((left, right))
    }

    fn misfit(&self, left: &Quantity, right: &Quantity) -> Mistake {
        let (wrong, other) = (right, left);
        let (said, beside) = (self.said(&wrong.at), self.said(&other.at));
        match (wrong.measure.text(), other.measure.text()) {
            (Some(unit), Some(fitting)) if is_literal(wrong) => Mistake::new(
                wrong.at.clone(),
                format!("`{unit}` does not fit: `{beside}` is in {fitting}"),
            )
            .help(format!("write a number in {fitting}")),
            (Some(unit), Some(fitting)) => {
                let message = format!("`{said}` is in {unit}, `{beside}` in {fitting}");
                Mistake::new(wrong.at.clone(), message).help("units of one kind can be compared")
            }
            _ => Mistake::new(wrong.at.clone(), format!("`{beside}` has no unit"))
                .help("leave the unit out"),
        }
    }
}

/// Whether it is only a number with its unit.
fn is_literal(quantity: &Quantity) -> bool {
    matches!(quantity.number, Number::Constant(_))
}
