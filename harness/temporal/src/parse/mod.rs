//! Recursive descent from text to conditions. It also resolves signals and checks units.
//!
//! Precedence from loosest to tightest: `->`, `or`, `and`, `until` and `since`, `not`, comparisons, `+ -`, `* /`, the
//! sign.

mod comparison;
mod condition;
mod lexer;
mod quantity;
mod signal;
mod window;

use crate::formula::{Condition, Formula, Premise, Used};
use crate::mistake::Mistake;
use crate::number::Number;
use crate::signals::{Signal, Signals};
use lexer::{Token, token};
use quantity::{Measure, Quantity};
use std::ops::Range;
use window::HORIZON_MAX;

/// The longest formula. Assumption: a longer one is several properties.
const BYTES_MAX: usize = 2_000;

/// Nesting of parentheses and operators. Assumption: no reader follows more; half a thread's stack if nothing is optimised.
const NESTING_MAX: usize = 24;

struct Parser<'a> {
    text: &'a str,
    signals: &'a dyn Signals,
    /// The signals found so far, in slot order.
    found: Vec<(Used, Signal)>,
    /// Those of the comparisons so far.
    units: Vec<String>,
    next: Token<'a>,
    at: Range<usize>,
    /// End of the previous token.
    end: usize,
    nesting: usize,
    /// Of the whole formula, if it is `a -> b`.
    premise: Option<Premise>,
}

struct Part {
    what: What,
    at: Range<usize>,
    /// The position of its `until` or `since`, if no parentheses enclose it.
    bare: Option<Range<usize>>,
    /// Whether it ends with the scope of a colon.
    is_open: bool,
}

enum What {
    Condition(Condition),
    Quantity(Quantity),
    Named(String),
}

impl Formula {
    /// Parses a formula whose signals are among `signals`. The head of the crate describes the language.
    ///
    /// # Errors
    ///
    /// The first [`Mistake`], with its position.
    pub fn parse(text: &str, signals: &dyn Signals) -> Result<Self, Mistake> {
        if text.len() > BYTES_MAX {
            let message = format!("a formula has at most {BYTES_MAX} bytes");
            return Err(Mistake::new(0..text.len(), message).help(DIVIDE));
        }
        let (next, at) = token(text, 0)?;
        let mut parser = Parser {
            text,
            signals,
            found: Vec::new(),
            units: Vec::new(),
            next,
            at,
            end: 0,
            nesting: 0,
            premise: None,
        };
        let whole = parser.implication()?;
        if parser.next != Token::End {
            return Err(parser.unexpected("an operator"));
        }
        let condition = parser.condition(whole)?;
        if condition.horizon() > HORIZON_MAX {
            let message = "the formula looks more than an hour ahead";
            return Err(
                Mistake::new(0..text.len(), message).help("windows within one another add up")
            );
        }
        let signals = parser.found.into_iter().map(|(used, _)| used).collect();
        let (text, units, premise) = (text.to_owned(), parser.units, parser.premise);
        Ok(Self { text, condition, signals, units, premise })
    }
}

const DIVIDE: &str = "divide it: several properties, each with its own name";

impl<'a> Parser<'a> {
    fn advance(&mut self) -> Result<(), Mistake> {
        self.end = self.at.end;
        (self.next, self.at) = token(self.text, self.at.end)?;
        Ok(())
    }

    fn is_symbol(&self, symbol: &str) -> bool {
        self.next == Token::Symbol(symbol)
    }

    fn expect(&mut self, symbol: &str) -> Result<(), Mistake> {
        if !self.is_symbol(symbol) {
            return Err(self.unexpected(&format!("`{symbol}`")));
        }
        self.advance()
    }

    fn unexpected(&self, expected: &str) -> Mistake {
        let found = match self.next {
            Token::End => "the end".to_owned(),
            _ => format!("`{}`", self.said(&self.at)),
        };
        Mistake::new(self.at.clone(), format!("expected {expected}, found {found}"))
    }

    fn said(&self, at: &Range<usize>) -> &'a str {
        self.text.get(at.clone()).unwrap_or_default()
    }

    /// Parses one level deeper, with a limit so that no text overflows the stack.
    fn deeper<T>(
        &mut self,
        read: impl FnOnce(&mut Self) -> Result<T, Mistake>,
    ) -> Result<T, Mistake> {
        self.nesting += 1;
        if self.nesting > NESTING_MAX {
            return Err(Mistake::new(self.at.clone(), "nested too deeply").help(DIVIDE));
        }
        let read = read(self)?;
        self.nesting -= 1;
        Ok(read)
    }
}

impl Part {
    fn condition(condition: Condition, at: Range<usize>) -> Self {
        Self { what: What::Condition(condition), at, bare: None, is_open: false }
    }

    fn quantity(number: Number, measure: Measure, at: Range<usize>) -> Self {
        let what = What::Quantity(Quantity { number, measure, at: at.clone() });
        Self { what, at, bare: None, is_open: false }
    }
}
