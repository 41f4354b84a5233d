//! From words to operations, by precedence climbing.
//!
//! From the loosest to the tightest: `or`, `and`, `not`, comparisons (which do not chain), `+ -`,
//! `* / %`, the sign, `^` (from the right). As in mathematics `-x^2` is `-(x^2)`.

use super::lexer::{Token, token};
use super::operation::{Binary, FUNCTIONS, Function, Unary};
use super::{ExpressionError, Operation, STACK_MAX, Scope};
use crate::hint;
use std::ops::Range;

/// Parentheses, functions and signs within one another. Assumption: nobody reads more.
const NESTING_MAX: usize = 100;

const NOT: u8 = 3;
const COMPARISON: u8 = 4;
const SIGN: u8 = 7;

struct Parser<'a> {
    text: &'a str,
    scope: &'a dyn Scope,
    next: Token<'a>,
    at: Range<usize>,
    operations: Vec<Operation>,
    /// Values on the stack behind the last operation.
    height: usize,
    nesting: usize,
}

/// The operations of the expression.
pub(super) fn parse(text: &str, scope: &dyn Scope) -> Result<Vec<Operation>, ExpressionError> {
    let (next, at) = token(text, 0)?;
    let operations = Vec::new();
    let mut parser = Parser { text, scope, next, at, operations, height: 0, nesting: 0 };
    parser.expression(0)?;
    match parser.next {
        Token::End => Ok(parser.operations),
        _ => Err(parser.unexpected("an operator")),
    }
}

/// How tightly an operator binds on its left and what it does.
fn operator(token: Token<'_>) -> Option<(u8, Binary)> {
    Some(match token {
        Token::Name("or") => (1, Binary::Or),
        Token::Name("and") => (2, Binary::And),
        Token::Symbol("<") => (COMPARISON, Binary::Less),
        Token::Symbol("<=") => (COMPARISON, Binary::LessOrEqual),
        Token::Symbol(">") => (COMPARISON, Binary::Greater),
        Token::Symbol(">=") => (COMPARISON, Binary::GreaterOrEqual),
        Token::Symbol("==") => (COMPARISON, Binary::Equal),
        Token::Symbol("!=") => (COMPARISON, Binary::NotEqual),
        Token::Symbol("+") => (5, Binary::Add),
        Token::Symbol("-") => (5, Binary::Subtract),
        Token::Symbol("*") => (6, Binary::Multiply),
        Token::Symbol("/") => (6, Binary::Divide),
        Token::Symbol("%") => (6, Binary::Modulo),
        Token::Symbol("^") => (8, Binary::Power),
        _ => return None,
    })
}

impl<'a> Parser<'a> {
    /// An expression of operators that bind at least as tightly as `least`.
    fn expression(&mut self, least: u8) -> Result<(), ExpressionError> {
        self.nesting += 1;
        if self.nesting > NESTING_MAX {
            let message = "the expression is nested too deeply";
            return Err(self.error(self.at.clone(), message, Some(SPLIT.to_owned())));
        }
        self.operand()?;
        while let Some((power, binary)) = operator(self.next) {
            if power < least {
                break;
            }
            self.advance()?;
            // What binds from the right leaves its equals to its right side.
            self.expression(if binary == Binary::Power { SIGN } else { power + 1 })?;
            self.emit(Operation::Binary(binary))?;
            if power == COMPARISON && operator(self.next).is_some_and(|(next, _)| next == power) {
                let help = "write `a < b and b < c`".to_owned();
                return Err(self.error(self.at.clone(), "comparisons do not chain", Some(help)));
            }
        }
        self.nesting -= 1;
        Ok(())
    }

    fn operand(&mut self) -> Result<(), ExpressionError> {
        match self.next {
            Token::Number(number) => {
                self.advance()?;
                self.emit(Operation::Constant(number))
            }
            Token::Symbol("(") => {
                self.advance()?;
                self.expression(0)?;
                self.expect(")")
            }
            Token::Symbol("-") => {
                self.advance()?;
                self.expression(SIGN)?;
                self.emit(Operation::Unary(Unary::Negate))
            }
            Token::Symbol("+") => {
                self.advance()?;
                self.expression(SIGN)
            }
            Token::Name("not") => {
                self.advance()?;
                self.expression(NOT)?;
                self.emit(Operation::Unary(Unary::Not))
            }
            Token::Name("and" | "or") | Token::Symbol(_) | Token::End => {
                Err(self.unexpected("a number, a name or `(`"))
            }
            Token::Name("pi") => {
                self.advance()?;
                self.emit(Operation::Constant(std::f64::consts::PI))
            }
            Token::Name(name) => {
                let at = self.at.clone();
                self.advance()?;
                if self.next == Token::Symbol("(") {
                    return self.call(name, at);
                }
                if FUNCTIONS.iter().any(|(known, _)| *known == name) {
                    let message = format!("`{name}` is a function");
                    return Err(self.error(at, &message, Some(format!("write `{name}(...)`"))));
                }
                let slot = self.scope.variable(name);
                let slot = slot.map_err(|(what, help)| self.error(at, &what, Some(help)))?;
                self.emit(Operation::Variable(slot))
            }
        }
    }

    fn call(&mut self, name: &str, at: Range<usize>) -> Result<(), ExpressionError> {
        let found = FUNCTIONS.iter().find(|(known, _)| *known == name);
        let Some((_, function)) = found else {
            let known: Vec<_> = FUNCTIONS.iter().map(|(known, _)| *known).collect();
            let help = hint::proposal(name, &known);
            return Err(self.error(at, &format!("no function `{name}`"), Some(help)));
        };
        self.advance()?;
        if *function == Function::Last {
            return self.last();
        }
        let mut count = 0;
        loop {
            self.expression(0)?;
            count += 1;
            if let (Function::Fold(binary), true) = (function, count > 1) {
                self.emit(Operation::Binary(*binary))?;
            }
            if self.next != Token::Symbol(",") {
                break;
            }
            self.advance()?;
        }
        let at = at.start..self.at.end;
        self.expect(")")?;
        let (form, fits) = match function {
            Function::Of1(_) => (format!("{name}(x)"), count == 1),
            Function::Of2(_) => (format!("{name}(y, x)"), count == 2),
            Function::Fold(_) => (format!("{name}(a, b, ...)"), count >= 2),
            Function::Clamp => ("clamp(x, low, high)".to_owned(), count == 3),
            Function::If => ("if(condition, then, else)".to_owned(), count == 3),
            Function::Last => ("last(state)".to_owned(), true),
        };
        if !fits {
            let message = format!("`{name}` does not take {count} values");
            return Err(self.error(at, &message, Some(format!("write `{form}`"))));
        }
        match function {
            Function::Of1(unary) => self.emit(Operation::Unary(*unary)),
            Function::Of2(binary) => self.emit(Operation::Binary(*binary)),
            Function::Fold(_) | Function::Last => Ok(()),
            Function::Clamp => self.emit(Operation::Clamp),
            Function::If => self.emit(Operation::Choose),
        }
    }

    /// The one name in the parentheses of `last`.
    fn last(&mut self) -> Result<(), ExpressionError> {
        let Token::Name(name) = self.next else { return Err(self.unexpected("a state")) };
        let slot = self.scope.last(name);
        let slot = slot.map_err(|(what, help)| self.error(self.at.clone(), &what, Some(help)))?;
        self.advance()?;
        self.expect(")")?;
        self.emit(Operation::Variable(slot))
    }

    fn emit(&mut self, operation: Operation) -> Result<(), ExpressionError> {
        let taken = match operation {
            Operation::Constant(_) | Operation::Variable(_) => 0,
            Operation::Unary(_) => 1,
            Operation::Binary(_) => 2,
            Operation::Choose | Operation::Clamp => 3,
        };
        self.height = self.height.saturating_sub(taken) + 1;
        if self.height > STACK_MAX {
            let message = "the expression keeps too many values at once";
            return Err(self.error(self.at.clone(), message, Some(SPLIT.to_owned())));
        }
        self.operations.push(operation);
        Ok(())
    }

    fn advance(&mut self) -> Result<(), ExpressionError> {
        (self.next, self.at) = token(self.text, self.at.end)?;
        Ok(())
    }

    fn expect(&mut self, symbol: &str) -> Result<(), ExpressionError> {
        if self.next != Token::Symbol(symbol) {
            return Err(self.unexpected(&format!("`{symbol}`")));
        }
        self.advance()
    }

    fn unexpected(&self, expected: &str) -> ExpressionError {
        let found = match self.next {
            Token::End => "the end".to_owned(),
            _ => format!("`{}`", &self.text[self.at.clone()]),
        };
        self.error(self.at.clone(), &format!("expected {expected}, found {found}"), None)
    }

    fn error(&self, at: Range<usize>, message: &str, help: Option<String>) -> ExpressionError {
        ExpressionError { at, message: message.to_owned(), help }
    }
}

const SPLIT: &str = "divide it: a state with a `value` is a part with a name";
