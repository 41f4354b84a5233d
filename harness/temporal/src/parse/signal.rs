//! Signals and their named values.

use super::quantity::{Measure, Quantity};
use super::{Parser, Part, What};
use crate::formula::{Comparator, Condition, Used, Width};
use crate::mistake::Mistake;
use crate::number::Number;
use crate::parse::lexer::{KEYWORDS, Token};
use crate::signals::{Protecting, Signal, proposal};
use std::ops::Range;

/// Threshold between 0, wrong, and 1, right.
const WRONG_OR_RIGHT: f64 = 0.5;

impl Parser<'_> {
    /// A signal: any name that no other rule takes.
    pub(super) fn signal(&mut self, name: &str) -> Result<Part, Mistake> {
        let at = self.at.clone();
        if KEYWORDS.contains(&name) {
            let mistake = self.unexpected("a signal, a number or `(`");
            return Err(match name {
                "within" | "for" | "always" | "eventually" | "once" | "historically" => {
                    mistake.help(format!("put parentheses around `{name} ...: ...`"))
                }
                _ => mistake,
            });
        }
        self.advance()?;
        let how = Protecting::ALL.into_iter().find(|how| self.next == Token::Name(how.word()));
        let found = match how {
            Some(how) => self.signals.protecting(name, how),
            None => self.signals.find(name),
        };
        let found = found.map_err(|not_found| not_found.at(at.clone()))?;
        if self.next == Token::Symbol("(") {
            let known = &KEYWORDS[11..];
            let mistake = Mistake::new(at, format!("`{name}` is a signal, no function"));
            return Err(mistake.help(format!("functions are {}", known.join(", "))));
        }
        let measure = Measure::of(&found.unit);
        let name = match how {
            Some(how) => format!("{name} {}", how.word()),
            None => name.to_owned(),
        };
        let slot = self.slot(name, found, false);
        if how.is_some() {
            self.advance()?;
            let right = Condition::Compare(
                Comparator::Greater,
                Number::Slot(slot),
                Number::Constant(WRONG_OR_RIGHT),
                Width { range: 1.0, unit: None },
            );
            return Ok(Part::condition(right, at.start..self.end));
        }
        Ok(Part::quantity(Number::Slot(slot), measure, at))
    }

    /// `sent(message)`, after the word.
    pub(super) fn message(&mut self, start: usize) -> Result<Part, Mistake> {
        self.expect("(")?;
        let Token::Name(name) = self.next else { return Err(self.unexpected("a message")) };
        let at = self.at.clone();
        self.advance()?;
        self.expect(")")?;
        let found = self.signals.message(name).map_err(|not_found| not_found.at(at))?;
        let slot = self.slot(format!("number of {name} sent"), found, true);
        let width = Width { range: 1.0, unit: None };
        let condition = Condition::Changes(Number::Slot(slot), width, 0.0);
        Ok(Part::condition(condition, start..self.end))
    }

    /// The slot of a signal; a signal that is used twice has one.
    fn slot(&mut self, name: String, found: Signal, counts: bool) -> usize {
        let known = self.found.iter().position(|(used, _)| used.index == found.index);
        known.unwrap_or_else(|| {
            self.found.push((Used { name, index: found.index, counts }, found));
            self.found.len() - 1
        })
    }

    /// Both sides of a comparison as numbers; a name stands for the value that the signal assigns to it.
    pub(super) fn named(
        &self,
        left: Part,
        right: Part,
        comparator: Comparator,
        operator_at: &Range<usize>,
    ) -> Result<(Quantity, Quantity), Mistake> {
        let word = self.said(operator_at);
        let is_equality = matches!(comparator, Comparator::Equal | Comparator::NotEqual);
        match (left, right) {
            (Part { what: What::Named(_), at, .. }, _)
            | (_, Part { what: What::Named(_), at, .. })
                if !is_equality =>
            {
                let mistake = Mistake::new(operator_at.clone(), format!("`{word}` of a name"));
                let said = self.said(&at);
                Err(mistake.help(format!("names are equal or not: `signal == {said}`")))
            }
            (Part { what: What::Named(name), at, .. }, right) => {
                let right = self.quantity(right, word)?;
                Ok((self.value(&name, at, &right)?, right))
            }
            (left, Part { what: What::Named(name), at, .. }) => {
                let left = self.quantity(left, word)?;
                let value = self.value(&name, at, &left)?;
                Ok((left, value))
            }
            (left, right) => Ok((self.quantity(left, word)?, self.quantity(right, word)?)),
        }
    }

    fn value(&self, name: &str, at: Range<usize>, beside: &Quantity) -> Result<Quantity, Mistake> {
        let slot = match beside.number {
            Number::Slot(slot) => self.found.get(slot),
            _ => None,
        };
        let Some((used, signal)) = slot else {
            let mistake = Mistake::new(at, "the name of a value stands beside a signal");
            return Err(mistake.help(format!("write `signal == \"{name}\"`")));
        };
        if let Some((_, value)) = signal.names.iter().find(|(known, _)| known == name) {
            let number = Number::Constant(*value);
            return Ok(Quantity { number, measure: Measure::Bare, at });
        }
        let known: Vec<_> = signal.names.iter().map(|(known, _)| known).collect();
        let mistake = Mistake::new(at, format!("`{}` has no value `{name}`", used.name));
        Err(if known.is_empty() {
            mistake.help("its values have no names: write the number")
        } else {
            mistake.help(proposal(name, &known))
        })
    }
}
