//! From tokens to operations, by precedence climbing.
//!
//! From the loosest to the tightest: `or`, `and`, `not`, comparisons (which do not chain), `+ -`, `* / %`, the sign,
//! `^` (right-associative). As in mathematics `-x^2` is `-(x^2)`.

mod call;
mod name;

use super::lexer::{Token, token};
use super::operation::{Binary, Unary};
use super::{ExpressionError, Operation, STACK_MAX, Scope};
use std::ops::Range;

/// Maximum nesting of parentheses, functions and signs. Assumption: deeper expressions are unreadable.
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
    /// Height of the stack after the last operation.
    height: usize,
    nesting: usize,
}

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
    /// Parses operators that bind at least as tightly as `least`.
    fn expression(&mut self, least: u8) -> Result<(), ExpressionError> {
        self.nesting += 1;
        if self.nesting > NESTING_MAX {
            let message = "the expression is nested too deeply";
            return Err(self.error(self.at.clone(), message, Some(SPLIT.to_owned())));
        }
        let variable = match self.next {
            Token::Name(name) => Some(name),
            _ => None,
        };
        let begin = self.operations.len();
        self.operand()?;
        // A single variable on the left of a comparison may be compared with the name of a value.
        let variable =
            variable.filter(|_| matches!(self.operations[begin..], [Operation::Variable(_)]));
        while let Some((power, binary)) = operator(self.next) {
            if power < least {
                break;
            }
            self.advance()?;
            if let (Token::Text(value), Binary::Equal | Binary::NotEqual, Some(variable), true) =
                (self.next, binary, variable, self.operations.len() == begin + 1)
            {
                let number = self.scope.named(variable, value);
                let number = number
                    .map_err(|(what, help)| self.error(self.at.clone(), &what, Some(help)))?;
                self.advance()?;
                self.emit(Operation::Constant(number))?;
                self.emit(Operation::Binary(binary))?;
                continue;
            }
            // A right-associative operator leaves its equals to its right side.
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
                match self.next {
                    Token::Symbol("(") => self.call(name, at),
                    _ => self.name(name, at),
                }
            }
            Token::Text(_) => {
                let help = "write `mode == \"Closed\"`, the variable on the left".to_owned();
                let message = "the name of a value stands after `==` or `!=`";
                Err(self.error(self.at.clone(), message, Some(help)))
            }
        }
    }

    fn emit(&mut self, operation: Operation) -> Result<(), ExpressionError> {
        let taken = match operation {
            Operation::Constant(_) | Operation::Variable(_) | Operation::Aggregate(..) => 0,
            Operation::Unary(_) | Operation::Element(_) => 1,
            Operation::LookUp(ref table) => table.dimensions(),
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
