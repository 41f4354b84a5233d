//! Comparisons: numbers on both sides, a value name on one side, ranges, tolerances.

use super::lexer::Token;
use super::quantity::Quantity;
use super::{Parser, Part, What};
use crate::formula::{self, Comparator, Condition};
use crate::mistake::Mistake;
use crate::number::{Binary, Number};
use std::ops::Range;

/// The largest number of steps of which a double holds each.
const WHOLE_MAX: f64 = 9_007_199_254_740_992.0;

impl Parser<'_> {
    pub(super) fn comparison(&mut self) -> Result<Part, Mistake> {
        let left = self.sum()?;
        let Some(comparator) = self.comparator() else { return Ok(left) };
        let start = left.at.start;
        let operator_at = self.at.clone();
        self.advance()?;
        let right = self.sum()?;
        for part in [&left, &right] {
            if let What::Condition(_) = part.what {
                let message =
                    format!("`{}` compares numbers, not conditions", self.said(&operator_at));
                let mistake = Mistake::new(operator_at, message);
                return Err(mistake.help("`and`, `or` and `->` join conditions"));
            }
        }
        let (left, right) = self.named(left, right, comparator, &operator_at)?;
        if self.is_symbol("+-") || self.is_symbol("±") {
            let condition = self.near(left, right, comparator, &operator_at)?;
            return Ok(Part::condition(condition, start..self.end));
        }
        let middle = right.clone();
        let mut condition = self.compared(left, right, comparator, start..self.end)?;
        if let Some(second) = self.comparator() {
            let at = self.at.clone();
            if direction(comparator).is_none() || direction(comparator) != direction(second) {
                let mistake = Mistake::new(at, "these two comparisons do not chain");
                return Err(mistake.help("`1 < x < 2` does; else write `a < b and b > c`"));
            }
            self.advance()?;
            let part = self.sum()?;
            let right = self.quantity(part, "<")?;
            let end = self.compared(middle.clone(), right, second, at.start..self.end)?;
            condition = Condition::And(Box::new(condition), Box::new(end));
            if self.comparator().is_some() {
                let mistake = Mistake::new(self.at.clone(), "a range has two ends");
                return Err(mistake.help("write `and` between ranges"));
            }
        }
        Ok(Part::condition(condition, start..self.end))
    }

    fn comparator(&self) -> Option<Comparator> {
        let Token::Symbol(symbol) = self.next else { return None };
        Comparator::ALL.into_iter().find(|comparator| comparator.symbol() == symbol)
    }

    fn compared(
        &mut self,
        left: Quantity,
        right: Quantity,
        comparator: Comparator,
        at: Range<usize>,
    ) -> Result<Condition, Mistake> {
        let (left, right) = self.alike(left, right)?;
        let width = self.pair(&left, &right.number, at)?;
        Ok(Condition::Compare(comparator, left.number, right.number, width))
    }

    /// How far two numbers that can be compared can be apart; at least one is no constant.
    fn pair(
        &mut self,
        left: &Quantity,
        right: &Number,
        at: Range<usize>,
    ) -> Result<formula::Width, Mistake> {
        if let (Number::Constant(_), Number::Constant(_)) = (&left.number, right) {
            let mistake = Mistake::new(at, "no signal is compared here: it never changes");
            return Err(mistake.help("put a signal on one side"));
        }
        self.told_apart(&left.number, right, at)?;
        Ok(self.width(left, right))
    }

    /// How far the two, which are in one unit, can be apart.
    pub(super) fn width(&mut self, left: &Quantity, right: &Number) -> formula::Width {
        let of = |slot: usize| self.found.get(slot).and_then(|(_, signal)| signal.range);
        let apart = left.number.range(&of).zip(right.range(&of)).map(|(left, right)| {
            let (least, greatest) = Binary::Subtract.range(left, right);
            greatest - least
        });
        let is_share = |range: &f64| *range > 0.0 && range.is_finite();
        let unit = left.measure.text().map(|text| {
            let known = self.units.iter().position(|unit| unit == text);
            known.unwrap_or_else(|| {
                self.units.push(text.to_owned());
                self.units.len() - 1
            })
        });
        formula::Width { range: apart.filter(is_share).unwrap_or(1.0), unit }
    }

    /// Refuses to compare a signal with a number, or with a signal, where doubles do not hold each of its steps.
    fn told_apart(&self, left: &Number, right: &Number, at: Range<usize>) -> Result<(), Mistake> {
        for (one, other) in [(left, right), (right, left)] {
            let Number::Slot(slot) = one else { continue };
            let Some((used, signal)) = self.found.get(*slot) else { continue };
            let end = WHOLE_MAX * signal.step;
            let reaches = |range: Option<(f64, f64)>| {
                range.is_some_and(|(least, greatest)| least.abs().max(greatest.abs()) > end)
            };
            let is_beyond = match other {
                Number::Constant(value) => value.abs() > end,
                Number::Slot(slot) => {
                    let beside = self.found.get(*slot).and_then(|(_, signal)| signal.range);
                    reaches(signal.range) && reaches(beside)
                }
                _ => false,
            };
            if end > 0.0 && is_beyond {
                let message = format!("values of `{}` beyond {end} are not told apart", used.name);
                let help = "numbers are doubles: compare a smaller one, or describe the bits as several signals";
                return Err(Mistake::new(at, message).help(help));
            }
        }
        Ok(())
    }

    /// `x == 5 +- 0.1`.
    fn near(
        &mut self,
        left: Quantity,
        right: Quantity,
        comparator: Comparator,
        operator_at: &Range<usize>,
    ) -> Result<Condition, Mistake> {
        let is_near = match comparator {
            Comparator::Equal => true,
            Comparator::NotEqual => false,
            _ => {
                let mistake = Mistake::new(self.at.clone(), "a tolerance belongs to `==` or `!=`");
                return Err(mistake.help("write `x == 5 +- 0.1`"));
            }
        };
        self.advance()?;
        let part = self.sum()?;
        let at = part.at.clone();
        let tolerance = self.quantity(part, "+-")?;
        if matches!(tolerance.number, Number::Constant(value) if value < 0.0) {
            return Err(Mistake::new(at, "a tolerance is not negative").help("leave out the sign"));
        }
        let (left, right) = self.alike(left, right)?;
        let (left, tolerance) = self.alike(left, tolerance)?;
        let width = self.pair(&left, &right.number, operator_at.clone())?;
        Ok(Condition::Near(is_near, left.number, right.number, tolerance.number, width))
    }
}

/// Whether it points up or down; `None` for `==` and `!=`.
fn direction(comparator: Comparator) -> Option<bool> {
    match comparator {
        Comparator::Less | Comparator::LessOrEqual => Some(true),
        Comparator::Greater | Comparator::GreaterOrEqual => Some(false),
        Comparator::Equal | Comparator::NotEqual => None,
    }
}
