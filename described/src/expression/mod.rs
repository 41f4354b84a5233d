//! Expressions: read once, then evaluated at every step without allocation.
//!
//! The language is in the head of the crate. Transcendental functions are those of `libm`: the same
//! numbers on every platform.

mod lexer;
mod operation;
mod parser;
#[cfg(test)]
mod tests;

pub(crate) use operation::is_reserved;

use operation::{Binary, Unary};
use std::ops::Range;

/// Values that wait for their operator while an expression is evaluated; more is refused when it is read.
pub(crate) const STACK_MAX: usize = 32;

/// The longest expression. Assumption: what is longer is a model of its own.
pub(crate) const EXPRESSION_BYTES_MAX: usize = 2_000;

/// An expression that was read: what to do, operands before operators.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Expression {
    operations: Vec<Operation>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Operation {
    Constant(f64),
    /// The value in this slot.
    Variable(usize),
    Unary(Unary),
    Binary(Binary),
    /// Condition, then and else become one of the latter two.
    Choose,
    /// Value, least and greatest become the value between them.
    Clamp,
}

/// Why a text is no expression.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ExpressionError {
    /// Which bytes of it are meant.
    pub(crate) at: Range<usize>,
    pub(crate) message: String,
    pub(crate) help: Option<String>,
}

/// Where variables are found.
pub(crate) trait Scope {
    /// The slot of a variable, or the message and the help.
    fn variable(&self, name: &str) -> Result<usize, (String, String)>;
    /// The slot that has a variable's value at the end of the step before.
    fn last(&self, name: &str) -> Result<usize, (String, String)>;
}

impl Expression {
    /// Always the same.
    pub(crate) fn constant(value: f64) -> Self {
        Self { operations: vec![Operation::Constant(value)] }
    }

    /// Reads an expression whose variables are in `scope`.
    pub(crate) fn parse(text: &str, scope: &dyn Scope) -> Result<Self, ExpressionError> {
        if text.len() > EXPRESSION_BYTES_MAX {
            let message = format!("an expression has at most {EXPRESSION_BYTES_MAX} characters");
            let help = Some("divide it: a state with a `value` is a part with a name".to_owned());
            return Err(ExpressionError { at: 0..text.len(), message, help });
        }
        parser::parse(text, scope).map(|operations| Self { operations })
    }

    /// The slots that it reads.
    pub(crate) fn variables(&self) -> impl Iterator<Item = usize> {
        self.operations.iter().filter_map(|operation| match operation {
            Operation::Variable(slot) => Some(*slot),
            _ => None,
        })
    }

    /// Its value with these variables; not a number where it has none.
    pub(crate) fn value(&self, variables: &[f64]) -> f64 {
        let mut stack = Stack { values: [f64::NAN; STACK_MAX], height: 0 };
        for operation in &self.operations {
            let value = match *operation {
                Operation::Constant(value) => value,
                Operation::Variable(slot) => variables.get(slot).copied().unwrap_or(f64::NAN),
                Operation::Unary(unary) => unary.apply(stack.pop()),
                Operation::Binary(binary) => {
                    let right = stack.pop();
                    binary.apply(stack.pop(), right)
                }
                Operation::Clamp => {
                    let (high, low, x) = (stack.pop(), stack.pop(), stack.pop());
                    Binary::Max.apply(low, Binary::Min.apply(high, x))
                }
                Operation::Choose => {
                    let (otherwise, then, condition) = (stack.pop(), stack.pop(), stack.pop());
                    match condition {
                        unknown if unknown.is_nan() => f64::NAN,
                        0.0 => otherwise,
                        _ => then,
                    }
                }
            };
            stack.push(value);
        }
        stack.pop()
    }
}

/// [`parser`] has seen to it that it never overflows.
struct Stack {
    values: [f64; STACK_MAX],
    height: usize,
}

impl Stack {
    fn push(&mut self, value: f64) {
        if let Some(place) = self.values.get_mut(self.height) {
            *place = value;
            self.height += 1;
        }
    }

    fn pop(&mut self) -> f64 {
        self.height = self.height.saturating_sub(1);
        self.values[self.height]
    }
}
